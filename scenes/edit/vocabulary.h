#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/edit/outline.h"

namespace tessera::edit {

/// What can be typed at a place.
struct Completion {
  std::string label;
  std::string insert;  ///< in place of `replaced`
  std::string detail;  ///< its kind, unit, range and default
  std::string help;
};

struct Completions {
  SourceRange replaced;  ///< the part of a word that stands there
  std::vector<Completion> items;
  enum class Files { none, model, picture };
  Files files = Files::none;  ///< names of files that can stand there, too
  bool needs_quotes = false;  ///< they do, where they stand in none yet
};
Completions completions(const Outline& outline, size_t offset);

/// What is known of the word at a place.
struct Hover {
  SourceRange range;
  std::string title;
  std::string detail;
  std::string help;
};
std::optional<Hover> hover(const Outline& outline, size_t offset);

}  // namespace tessera::edit
