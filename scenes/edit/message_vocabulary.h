#pragma once

#include <optional>
#include <string>

#include "scenes/edit/vocabulary.h"

namespace tessera::edit {

Completions message_completions(const Outline& outline, size_t offset);
std::optional<Hover> message_hover(const Outline& outline, size_t offset);

/// "number in deg, above 0 and below 180; default 45".
std::string detail_of(const Field& field);

}  // namespace tessera::edit
