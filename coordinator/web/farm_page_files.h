#pragma once

#include <optional>
#include <string_view>

#include "web/embedded_file.h"

namespace tessera {

/// A file of coordinator/web/page by the path of a request; nullopt for any other path.
std::optional<EmbeddedFile> find_farm_page_file(std::string_view path);

}  // namespace tessera
