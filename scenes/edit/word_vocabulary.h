#pragma once

#include <optional>

#include "scenes/edit/vocabulary.h"

namespace tessera::edit {

/// The word that a place is in or at the end of.
/// What stands between the quotes around the offset.
SourceRange quoted_around(std::string_view text, size_t offset);
SourceRange word_around(std::string_view text, size_t offset);

// Of CRT scripts, and of X3D in XML.
Completions crt_completions(const Outline& outline, size_t offset);
std::optional<Hover> crt_hover(const Outline& outline, size_t offset);
Completions xml_completions(const Outline& outline, size_t offset);
std::optional<Hover> xml_hover(const Outline& outline, size_t offset);

}  // namespace tessera::edit
