#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "base/error.h"

namespace tessera {

/// Reads the words and numbers of a text in memory that takes spaces and line ends alike. A value
/// that looks at text of its caller's.
class TokenReader {
 public:
  /// Begins at byte `begin` of `text`; `name` is what errors call it.
  TokenReader(std::string_view text, std::string name, size_t begin = 0)
      : text_(text), name_(std::move(name)), at_(begin), word_(begin) {}

  /// The next word, empty at the end of the text.
  std::string_view word();
  /// What is left of the line, without the spaces around it. Goes to the next line.
  std::string_view rest_of_line();
  /// Any number, infinite and NaN too; infinite where double precision cannot hold it.
  double number(const char* what);

  size_t offset() const { return at_; }
  size_t remaining() const { return text_.size() - at_; }
  /// Where the word that was read last begins. Takes time in the length of the text.
  SourcePlace place() const;
  /// The same word in quotes, shortened.
  std::string quoted_word() const;
  Error error(std::string_view found, std::string_view expected) const {
    return scene_error(place(), found, expected);
  }

 private:
  std::string_view text_;
  std::string name_;
  size_t at_, word_;
};

}  // namespace tessera
