#pragma once

#include <optional>

#include "scenes/edit/vocabulary.h"

namespace tessera::edit {

/// What stands between the quotes around the offset.
SourceRange quoted_around(std::string_view text, size_t offset);
/// The word that a place is in or at the end of.
SourceRange word_around(std::string_view text, size_t offset);

// Of CRT scripts, and of X3D in XML and in the classic encoding.
Completions crt_completions(const Outline& outline, size_t offset);
std::optional<Hover> crt_hover(const Outline& outline, size_t offset);
Completions xml_completions(const Outline& outline, size_t offset);
Completions classic_completions(const Outline& outline, size_t offset);
std::optional<Hover> x3d_hover(const Outline& outline, size_t offset);

}  // namespace tessera::edit
