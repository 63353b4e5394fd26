#include "studio/files/document.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/file.h"
#include "base/lower_case.h"
#include "base/plain_text.h"

namespace tessera {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF", kReplacement = "\xEF\xBF\xBD";

bool is_within_character(std::string_view text, size_t at) {
  return at < text.size() && (static_cast<unsigned char>(text[at]) & 0xC0) == 0x80;
}

/// `part` of a text in which each line end became \n. A chunk never ends within \r\n.
void append_plain(std::string_view part, std::string& out) {
  for (size_t at = 0; at < part.size();) {
    const size_t end = std::min(part.find('\r', at), part.size());
    out += part.substr(at, end - at);
    if (end == part.size()) break;
    out += '\n';
    at = end + (part.substr(end, 2) == "\r\n" ? 2 : 1);
  }
}

/// The first byte that is no text in UTF-8.
size_t first_fault(std::string_view bytes) {
  return std::min(find_invalid_utf8(bytes), bytes.find('\0'));
}

std::string_view encoding_of(std::string_view bytes) {
  if (is_utf16(bytes)) return "UTF-16";
  return first_fault(bytes) == std::string_view::npos ? "UTF-8" : "not UTF-8";
}

/// Why a file of those bytes cannot be edited; empty where it can.
std::string fault_of(std::string_view bytes) {
  if (is_utf16(bytes)) return "the file is in UTF-16; only UTF-8 can be edited";
  const size_t bad = first_fault(bytes);
  if (bad == std::string_view::npos) return {};
  const auto line =
      std::count(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(bad), '\n');
  return fmt::format("line {} has the byte 0x{:02x}; only text in UTF-8 can be edited", line + 1,
                     static_cast<unsigned char>(bytes[bad]));
}

/// With a replacement character for each byte that is no text.
std::string shown(std::string_view bytes) {
  std::string out;
  out.reserve(bytes.size());
  while (!bytes.empty() && out.size() < Document::kMostBytes) {
    std::string_view piece = bytes.substr(0, bytes.find('\0'));
    bytes.remove_prefix(std::min(piece.size() + 1, bytes.size()));
    const bool ends_with_nul = piece.data() + piece.size() != bytes.data();
    while (!piece.empty()) {
      const size_t good = std::min(find_invalid_utf8(piece), piece.size());
      out += piece.substr(0, good);
      if (good < piece.size()) out += kReplacement;
      piece.remove_prefix(std::min(good + 1, piece.size()));
    }
    if (ends_with_nul) out += kReplacement;
  }
  return out;
}

/// A beginning of at most that many bytes: whole lines, unless there is but one.
std::string_view head_of(std::string_view bytes, size_t most) {
  std::string_view head = bytes.substr(0, most);
  if (const size_t end = head.rfind('\n'); end != std::string_view::npos)
    return head.substr(0, end + 1);
  while (!head.empty() && is_within_character(bytes, head.size())) head.remove_suffix(1);
  return head;
}

std::optional<std::string> fault_of(const TextChange& change) {
  if (change.text.find('\r') != std::string::npos) return "a change has \\r; expected \\n alone";
  if (change.text.find('\0') != std::string::npos) return "a change has a NUL; expected text";
  if (find_invalid_utf8(change.text) != std::string_view::npos)
    return "a change is not UTF-8; expected text";
  return std::nullopt;
}

std::string too_large(size_t bytes) {
  return fmt::format("the text would have {} bytes; expected at most {}", bytes,
                     Document::kMostBytes);
}

/// A text that is put behind what was made, with line ends as the file has them.
std::string with_file_ends(const std::string& text, const TextRewriter& made, bool before_newline) {
  std::string out;
  if (text.find('\n') == std::string::npos) {
    out = text;
  } else {
    const std::string_view end = made.last_end();
    for (const char c : text) c == '\n' ? out += end : out += c;
  }
  // A \r and a \n that come together would be one end where the editor has two. After a \r new
  // lines end with \r.
  if (out.empty()) return made.last_byte() == '\r' && before_newline ? "\r" : "";
  if (before_newline && out.back() == '\r') out += '\n';
  return out;
}

size_t ends_by(LineRule rule, const TextExtent& extent) {
  return rule == LineRule::any ? extent.line_ends() : extent.lf + extent.crlf;
}

}  // namespace

LineRule line_rule_of(std::string_view file_name) {
  const std::string name = lower_case(std::string(file_name));
  for (const std::string_view ending : {".crt", ".obj", ".mtl", ".ply", ".stl"}) {
    if (name.ends_with(ending)) return LineRule::any;
  }
  return LineRule::lf;
}

Document::Document(std::string_view file_bytes, bool is_whole) {
  const std::string_view marked =
      is_whole && file_bytes.size() <= kMostBytes ? file_bytes : head_of(file_bytes, kMostBytes);
  std::string_view text = skip_byte_order_mark(marked);
  marks_ = (marked.size() - text.size()) / kByteOrderMark.size();
  encoding_ = encoding_of(text);
  if (!is_whole || file_bytes.size() > kMostBytes) {
    why_fixed_ =
        fmt::format("the file has more than {} MiB: its beginning is shown", kMostBytes >> 20);
  } else {
    why_fixed_ = fault_of(text);
  }
  if (is_editable()) {
    chunks_ = TextChunks(text);
    return;
  }
  original_ = std::make_shared<const std::string>(file_bytes);
  chunks_ = TextChunks(shown(text));
}

std::string_view Document::line_ends() const {
  const TextExtent& all = chunks_.extent();
  const size_t ends = all.line_ends();
  if (all.lf == ends) return "lf";
  if (all.crlf == ends) return "crlf";
  return all.cr == ends ? "cr" : "mixed";
}

std::string Document::text() const {
  std::string out;
  out.reserve(chunks_.extent().text_bytes());
  chunks_.for_each([&](std::string_view part) { append_plain(part, out); });
  return out;
}

std::string Document::bytes() const {
  if (original_) return *original_;
  std::string out;
  out.reserve(marks_ * kByteOrderMark.size() + chunks_.extent().bytes);
  for (size_t i = 0; i < marks_; ++i) out += kByteOrderMark;
  chunks_.for_each([&](std::string_view part) { out += part; });
  return out;
}

Digest Document::hash() const { return Digest::of(bytes()); }

std::optional<std::string> Document::apply(std::span<const TextChange> changes) {
  if (!is_editable()) return why_fixed_;
  size_t reached = 0;
  std::vector<std::pair<size_t, size_t>> bytes;  // of each change
  bytes.reserve(changes.size());
  TextChunks::UnitCursor cursor(chunks_);
  for (const TextChange& change : changes) {
    if (change.from < reached) return "changes overlap or do not ascend";
    if (change.to < change.from || change.to > units())
      return fmt::format("a change of {} to {} lies outside of the text, which has {} units",
                         change.from, change.to, units());
    const auto from = cursor.find(change.from), to = cursor.find(change.to);
    if (from.units != change.from || to.units != change.to)
      return "a change begins or ends in a character";
    if (auto fault = fault_of(change)) return fault;
    bytes.emplace_back(from.bytes, to.bytes);
    reached = change.to;
  }
  TextRewriter writer(chunks_);
  // The \r that keeps a \r and the \n at `join` apart, until the next change tells whether that
  // stays.
  constexpr size_t kNowhere = std::string::npos;
  size_t join = kNowhere;
  const auto keep_apart = [&] {
    if (join != kNowhere) writer.replace_to(join, "\r");
    join = kNowhere;
  };
  for (size_t i = 0; i < changes.size(); ++i) {
    const auto [from, to] = bytes[i];
    if (join != from) keep_apart();
    writer.keep_to(from);
    if (to > from) join = kNowhere;
    const std::string made =
        with_file_ends(changes[i].text, writer, join == kNowhere && chunks_.byte_at(to) == '\n');
    const bool joins = changes[i].text.empty() && !made.empty();
    writer.replace_to(to, joins ? "" : made);
    if (joins) join = to;
  }
  keep_apart();
  TextChunks changed = writer.finish();
  const size_t size = changed.extent().bytes + marks_ * kByteOrderMark.size();
  if (size > kMostBytes) return too_large(size);
  chunks_ = std::move(changed);
  ++version_;
  return std::nullopt;
}

bool Document::adopt(std::string_view file_bytes) {
  Document other(file_bytes);
  if (!is_editable() || !other.is_editable() || other.text() != text()) return false;
  chunks_ = std::move(other.chunks_);
  marks_ = other.marks_;
  return true;
}

TextPosition Document::position_of(size_t offset) const {
  const TextExtent at = chunks_.prefix_of_units(offset);
  const TextExtent line = chunks_.prefix_of_lines(at.line_ends(), LineRule::any);
  return {at.line_ends() + 1, at.units - line.units + 1};
}

size_t Document::offset_of(TextPosition position) const {
  if (position.line == 0) return 0;
  if (position.line > lines()) return units();
  const size_t start = chunks_.prefix_of_lines(position.line - 1, LineRule::any).units;
  const size_t end = position.line < lines()
                         ? chunks_.prefix_of_lines(position.line, LineRule::any).units - 1
                         : units();
  const size_t column = std::max<size_t>(position.column, 1) - 1;
  return chunks_.prefix_of_units(start + std::min(column, end - start)).units;
}

size_t Document::unseen_marks() const {
  size_t bytes = 0;
  while (chunks_.byte_at(bytes) == 0xEF && chunks_.byte_at(bytes + 1) == 0xBB &&
         chunks_.byte_at(bytes + 2) == 0xBF)
    bytes += kByteOrderMark.size();
  return bytes;
}

size_t Document::offset_of_place(size_t line, size_t column, LineRule rule) const {
  if (line == 0) return 0;
  const size_t lines_there = ends_by(rule, chunks_.extent()) + 1;
  if (line > lines_there) return units();
  const size_t start = line == 1 ? unseen_marks() : chunks_.prefix_of_lines(line - 1, rule).bytes;
  const size_t end =
      line < lines_there ? chunks_.prefix_of_lines(line, rule).bytes - 1 : chunks_.extent().bytes;
  const size_t bytes = std::max<size_t>(column, 1) - 1;
  return chunks_.prefix_of_bytes(start + std::min(bytes, end - start)).units;
}

TextPosition Document::position_of_place(size_t line, size_t column, LineRule rule) const {
  return position_of(offset_of_place(line, column, rule));
}

TextPosition Document::place_of(size_t offset, LineRule rule) const {
  const TextExtent at = chunks_.prefix_of_units(offset);
  const size_t ends = ends_by(rule, at);
  const size_t start = ends == 0 ? unseen_marks() : chunks_.prefix_of_lines(ends, rule).bytes;
  return {ends + 1, std::max(at.bytes, start) - start + 1};
}

size_t Document::offset_of_file_byte(size_t byte) const {
  return chunks_.prefix_of_bytes(byte).units;
}

size_t Document::file_byte_of(size_t offset) const { return chunks_.prefix_of_units(offset).bytes; }

size_t Document::offset_of_text_byte(size_t byte) const {
  return chunks_.prefix_of_text_bytes(byte).units;
}

size_t Document::text_byte_of(size_t offset) const {
  return chunks_.prefix_of_units(offset).text_bytes();
}

std::vector<TextChange> difference(std::string_view before, std::string_view after) {
  if (before == after) return {};
  const size_t shorter = std::min(before.size(), after.size());
  size_t head = static_cast<size_t>(
      std::mismatch(before.begin(), before.begin() + static_cast<std::ptrdiff_t>(shorter),
                    after.begin())
          .first -
      before.begin());
  while (head > 0 && (is_within_character(before, head) || is_within_character(after, head)))
    --head;
  size_t tail = 0;
  while (tail < shorter - head &&
         before[before.size() - tail - 1] == after[after.size() - tail - 1])
    ++tail;
  // A tail that is all of the rest begins at `head`, which lies between characters.
  while (tail > 0 && is_within_character(before, before.size() - tail)) --tail;
  const std::string_view removed = before.substr(head, before.size() - tail - head);
  const size_t from = extent_of(before.substr(0, head)).units;
  return {{from, from + extent_of(removed).units,
           std::string(after.substr(head, after.size() - tail - head))}};
}

}  // namespace tessera
