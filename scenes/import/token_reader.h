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
      : text_(text), name_(std::move(name)), at_(begin), word_(begin), end_(text.size()) {}

  /// The next word, empty at the end of the text.
  std::string_view word();
  /// What is left of the line, without the spaces around it. Goes to the next line.
  std::string_view rest_of_line();
  /// Goes to the next line that is not blank, and reads as if the text ended where that line does.
  void enter_line();
  /// Goes to that line's end.
  void skip_line() { at_ = end_; }
  /// Goes to the end of that line, from which the whole text is read again.
  void leave_line();
  /// The next word as any number, infinite and NaN too; infinite where double precision cannot hold
  /// it, and NaN for what is no number.
  double number();

  size_t offset() const { return at_; }
  size_t remaining() const { return end_ - at_; }
  /// Where the word that was read last begins. Takes time in the length of the text.
  SourcePlace place() const;
  /// Where the word begins that was read last.
  size_t word_offset() const { return word_; }
  /// Whether there was no word any more where the last one was looked for.
  bool is_past_end() const { return word_ == end_; }
  /// The word that was read last in quotes, shortened.
  std::string quoted_word() const;
  Error error(std::string_view found, std::string_view expected) const {
    return scene_error(place(), found, expected);
  }

 private:
  std::string_view text_;
  std::string name_;
  size_t at_, word_;
  size_t end_;  ///< of what is read: the text, or the line that was entered
};

}  // namespace tessera
