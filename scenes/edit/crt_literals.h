#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "scenes/edit/edit.h"

namespace tessera::edit {

/// The literal of a value that stands in a script for the first time.
std::string new_crt_literal(const Field& field, std::string_view typed);
/// Why it may not stand there.
std::optional<Refusal> check_new_crt(const Outline& outline, const Field& field,
                                     std::string_view typed);
std::optional<Refusal> check_crt_parts(const Field& field, std::string_view typed);
std::optional<Refusal> check_crt_reference(const Outline& outline, std::string_view typed);

}  // namespace tessera::edit
