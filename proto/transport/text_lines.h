#pragma once

#include <string_view>
#include <vector>

namespace tessera {

/// A word of a line; columns count from 1, in bytes.
struct TextWord {
  std::string_view text;
  int column = 0;
};

/// A line with words on it; lines count from 1.
struct TextLine {
  int number = 0;
  std::vector<TextWord> words;
};

/// The lines of a text without those that are empty and without what follows a '#'. They point
/// into `text`.
std::vector<TextLine> text_lines(std::string_view text);

}  // namespace tessera
