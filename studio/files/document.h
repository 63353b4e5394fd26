#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/digest.h"
#include "studio/files/text_chunks.h"

namespace tessera {

/// Replaces what lies between two offsets, in UTF-16 code units of the editor's text, by UTF-8
/// whose line ends are \n alone.
struct TextChange {
  size_t from = 0;
  size_t to = 0;
  std::string text;
  friend bool operator==(const TextChange&, const TextChange&) = default;
};

/// A position in the editor's text. Both count from 1, the column in UTF-16 code units.
struct TextPosition {
  size_t line = 1;
  size_t column = 1;
  friend bool operator==(const TextPosition&, const TextPosition&) = default;
};

/// The rule of the reader of that file, by its ending.
LineRule line_rule_of(std::string_view file_name);

/// A text as the editor has it and as its file has it. The editor sees UTF-8 without a byte order
/// mark, whose lines end with \n; the file keeps its mark, each line's own end, and that its last
/// line has none. Bytes that are no such text are shown, and cannot be edited. A value: a copy
/// costs microseconds, and can be read by another thread.
class Document {
 public:
  /// Of the text and of the file.
  static constexpr size_t kMostBytes = size_t{8} << 20;

  /// An empty text.
  Document() = default;
  /// The document of a file of those bytes, at version 1. Where they are more than kMostBytes, or
  /// `is_whole` says that they are but the beginning of a file, a beginning is shown.
  explicit Document(std::string_view file_bytes, bool is_whole = true);

  /// Starts at 1; each apply() that was not refused raises it by one.
  uint64_t version() const { return version_; }
  bool is_editable() const { return why_fixed_.empty(); }
  /// Why the text cannot be edited, for the user; empty where it can.
  const std::string& why_not_editable() const { return why_fixed_; }
  bool has_byte_order_mark() const { return marks_ > 0; }
  /// "UTF-8", "UTF-16", or "not UTF-8" of bytes that are no text in either.
  std::string_view encoding() const { return encoding_; }
  /// "lf", "crlf", "cr" or, of several kinds, "mixed"; a text without line ends has "lf".
  std::string_view line_ends() const;

  /// As the editor has it.
  std::string text() const;
  /// As the file has it: of a document that was not edited, the bytes that it was made from.
  std::string bytes() const;
  /// Of bytes().
  Digest hash() const;
  /// The length of text() in UTF-16 code units, and the number of its lines: at least 1.
  size_t units() const { return chunks_.extent().units; }
  size_t lines() const { return chunks_.extent().line_ends() + 1; }

  /// Makes the changes, which are ascending, do not overlap and count in the text before any of
  /// them. Returns why they were refused, all together, and nothing where they were made. New
  /// lines end as the line before them does, or as most lines of the file.
  std::optional<std::string> apply(std::span<const TextChange> changes);
  /// Takes the line ends and the byte order mark of `file_bytes`, where their text is this one's;
  /// else returns false. For a file that changed on disk, once the editor has its text.
  bool adopt(std::string_view file_bytes);

  /// Conversions between an offset of text() in UTF-16 code units and other positions. What lies
  /// outside of the text, or within a character, is moved to the nearest position before it.
  TextPosition position_of(size_t offset) const;
  size_t offset_of(TextPosition position) const;
  /// Of a place as readers' errors have it: line and column from 1, the column in bytes of the
  /// line. A line of 0 gives 0; a column of 0, the beginning of its line. The rule is that of a
  /// reader that was given bytes(); one that was given text() counts by LineRule::any.
  size_t offset_of_place(size_t line, size_t column, LineRule rule) const;
  TextPosition position_of_place(size_t line, size_t column, LineRule rule) const;
  /// The inverse: the place that a reader would give to that offset.
  TextPosition place_of(size_t offset, LineRule rule) const;
  /// Of a byte of what readers see of bytes(): all but the byte order mark.
  size_t offset_of_file_byte(size_t byte) const;
  size_t file_byte_of(size_t offset) const;
  /// Of a byte of text().
  size_t offset_of_text_byte(size_t byte) const;
  size_t text_byte_of(size_t offset) const;

 private:
  size_t unseen_marks() const;

  TextChunks chunks_;  ///< without the byte order marks
  size_t marks_ = 0;   ///< byte order marks before the text: readers skip any number of them
  uint64_t version_ = 1;
  std::string why_fixed_;
  std::string_view encoding_ = "UTF-8";
  std::shared_ptr<const std::string> original_;  ///< the file, where `chunks_` do not give it back
};

/// The change that makes `after` of `before`, both with \n alone: none where they are equal.
std::vector<TextChange> difference(std::string_view before, std::string_view after);

}  // namespace tessera
