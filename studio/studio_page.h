#pragma once

#include <optional>
#include <string_view>

#include "web/embedded_file.h"

namespace tessera {

/// The files of the studio's page, by the path of their request.
std::optional<EmbeddedFile> find_studio_page_file(std::string_view path);

}  // namespace tessera
