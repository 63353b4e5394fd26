#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "base/error.h"
#include "base/open_input.h"

namespace tessera {

/// Reads the words and numbers of a text of lines, as OBJ and MTL are, piece by piece so that a
/// large file is never held whole. A backslash at a line's end joins the next line to it; lines end
/// with LF, CRLF or CR.
class LineReader {
 public:
  /// Opens `path`; throws scene_error where it cannot be read.
  explicit LineReader(const std::string& path);
  /// Reads `text` instead of a file; `name` is what errors call it.
  LineReader(std::string_view text, std::string name);

  /// Goes to the next line; false at the end of the text. The rest of the line before is skipped.
  bool next_line();
  /// The next word of the line, empty at its end. Valid until next_line().
  std::string_view word();
  /// The rest of the line without spaces around it and with its line joints as they are.
  std::string rest();
  bool at_line_end() {
    skip_space();
    word_ = at_;
    return is_line_end(*at_);
  }

  /// A finite number that single precision can hold.
  float number(const char* what);
  /// The same of any word: NaN for what is no finite number, infinite beyond single precision.
  float any_number();
  /// The rule that the number broke which any_number() returned last, and which number() refuses:
  /// "a coordinate that is finite", or "a coordinate" where it was no number at all.
  std::string rule(const char* what, float value) const;
  /// The next word if there is one.
  std::optional<float> optional_number(const char* what);
  std::optional<float> optional_any_number() {
    if (at_line_end() || *at_ == '#') return std::nullopt;
    return any_number();
  }
  /// Reads an integer that may be negative; leaves the place after its last digit. One of more than
  /// 12 digits is kTooLarge, or its negative. Nothing where there is no digit.
  std::optional<int64_t> index();
  static constexpr int64_t kTooLarge = int64_t{1} << 40;
  /// The character at the place, '\n' at the line's end; with `ahead` 1, where that is another, the
  /// one after it.
  char peek(size_t ahead = 0) const { return at_[ahead]; }
  void skip_char() { ++at_; }
  /// Whether a word ends here.
  bool at_word_end() const {
    return is_blank(*at_) || is_line_end(*at_) || (*at_ == '\\' && joint(at_) != 0);
  }

  /// Where the word that was read last begins.
  SourcePlace place() const { return place_of(word_); }
  const std::string& name() const { return name_; }
  Error error(std::string_view found, std::string_view expected) const;
  /// What stands where the last word began, in quotes, shortened.
  std::string quoted_word() const;

 private:
  static bool is_line_end(char c) { return c == '\n' || c == '\r'; }
  static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
  /// The length of the joint (backslash and line end) at `at`, or 0.
  static int joint(const char* at);

  bool refill();
  void skip_space() {
    while (is_blank(*at_)) ++at_;
    if (*at_ == '\\') skip_joints();
  }
  void skip_joints();
  SourcePlace place_of(const char* at) const;

  std::string name_;
  InputFile file_;
  std::string buffer_;   ///< whole lines, then the zero byte of every std::string
  std::string pending_;  ///< the piece of a line after the last whole one
  const char* at_ = nullptr;
  const char* end_ = nullptr;
  const char* word_ = nullptr;
  bool in_line_ = false;
  bool at_start_ = true;
  bool is_number_ = true;     ///< what any_number() read last
  int64_t lines_before_ = 0;  ///< lines of the text before buffer_
};

}  // namespace tessera
