#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace tessera::edit {

/// A stretch of a text in bytes: [begin, end).
struct SourceRange {
  uint32_t begin = 0, end = 0;

  uint32_t size() const { return end - begin; }
  bool is_empty() const { return begin == end; }
  bool contains(size_t offset) const { return begin <= offset && offset <= end; }
  bool contains(SourceRange inner) const { return begin <= inner.begin && inner.end <= end; }
  bool operator==(const SourceRange&) const = default;
};

/// Replaces the bytes of `range` by `text`. Several of one change are ascending, do not overlap,
/// and are all in terms of the text before the change.
struct TextEdit {
  SourceRange range;
  std::string text;

  bool operator==(const TextEdit&) const = default;
};

/// The text after `edits`, whose ranges must lie inside of it and ascend.
std::string apply_edits(std::string_view text, const std::vector<TextEdit>& edits);

/// The edits of apply_edits(text, edits) that give `text` back.
std::vector<TextEdit> inverse_edits(std::string_view text, const std::vector<TextEdit>& edits);

inline std::string_view text_of(std::string_view text, SourceRange range) {
  return text.substr(range.begin, range.size());
}

/// Blanks within a line.
inline bool is_blank(char c) { return c == ' ' || c == '\t'; }
/// Blanks and what ends lines.
inline bool is_space(char c) { return is_blank(c) || c == '\n' || c == '\r'; }

/// The bytes of a UTF-8 byte-order mark at the beginning: 0 or 3.
uint32_t byte_order_mark_size(std::string_view text);

/// The offset of the first byte of the line that `offset` is in. Lines end with LF, CR LF or CR.
uint32_t line_begin(std::string_view text, uint32_t offset);
/// The offset of the line's end mark, or of the end of the text.
uint32_t line_end(std::string_view text, uint32_t offset);
/// The offset behind the line's end mark.
uint32_t next_line(std::string_view text, uint32_t offset);

/// The blanks and tabs that the line of `offset` begins with.
std::string_view indentation(std::string_view text, uint32_t offset);
/// Whether only blanks and tabs stand before `offset` on its line.
bool begins_line(std::string_view text, uint32_t offset);
/// The end mark that lines around `offset` have: that of its own line, else of the line before,
/// else of the first line; "\n" in a text of one line.
std::string_view line_ending(std::string_view text, uint32_t offset);
/// One level of indentation as the text has it: the first indentation that is there; else `usual`.
std::string indentation_unit(std::string_view text, std::string_view usual);

/// Line and column of a byte, both from 1; the column counts bytes.
struct LineColumn {
  uint32_t line = 1, column = 1;
};
LineColumn line_column(std::string_view text, uint32_t offset);

}  // namespace tessera::edit
