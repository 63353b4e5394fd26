#include "scenes/edit/source_text.h"

#include <algorithm>

namespace tessera::edit {
namespace {

bool is_line_mark(char c) { return c == '\n' || c == '\r'; }

uint32_t clamped(std::string_view text, uint32_t offset) {
  return std::min(offset, static_cast<uint32_t>(text.size()));
}

/// The end mark at `at`, empty where there is none.
std::string_view mark_at(std::string_view text, uint32_t at) {
  if (at >= text.size() || !is_line_mark(text[at])) return {};
  const bool both = text[at] == '\r' && at + 1 < text.size() && text[at + 1] == '\n';
  return text.substr(at, both ? 2 : 1);
}

}  // namespace

std::string apply_edits(std::string_view text, const std::vector<TextEdit>& edits) {
  std::string made;
  size_t at = 0;
  for (const TextEdit& edit : edits) {
    made.append(text.substr(at, edit.range.begin - at));
    made.append(edit.text);
    at = edit.range.end;
  }
  made.append(text.substr(at));
  return made;
}

std::vector<TextEdit> inverse_edits(std::string_view text, const std::vector<TextEdit>& edits) {
  std::vector<TextEdit> inverse;
  int64_t shift = 0;
  for (const TextEdit& edit : edits) {
    const auto begin = static_cast<uint32_t>(edit.range.begin + shift);
    const auto size = static_cast<uint32_t>(edit.text.size());
    inverse.push_back({{begin, begin + size}, std::string(text_of(text, edit.range))});
    shift += int64_t{size} - int64_t{edit.range.size()};
  }
  return inverse;
}

uint32_t byte_order_mark_size(std::string_view text) {
  return text.starts_with("\xEF\xBB\xBF") ? 3 : 0;
}

uint32_t line_begin(std::string_view text, uint32_t offset) {
  uint32_t at = clamped(text, offset);
  while (at > 0 && !is_line_mark(text[at - 1])) --at;
  return at == 0 ? std::min(byte_order_mark_size(text), clamped(text, offset)) : at;
}

uint32_t line_end(std::string_view text, uint32_t offset) {
  uint32_t at = clamped(text, offset);
  while (at < text.size() && !is_line_mark(text[at])) ++at;
  return at;
}

uint32_t next_line(std::string_view text, uint32_t offset) {
  const uint32_t end = line_end(text, offset);
  return end + static_cast<uint32_t>(mark_at(text, end).size());
}

std::string_view indentation(std::string_view text, uint32_t offset) {
  const uint32_t begin = line_begin(text, offset);
  uint32_t end = begin;
  while (end < text.size() && (text[end] == ' ' || text[end] == '\t')) ++end;
  return text.substr(begin, end - begin);
}

bool begins_line(std::string_view text, uint32_t offset) {
  return line_begin(text, offset) + indentation(text, offset).size() >= offset;
}

std::string_view line_ending(std::string_view text, uint32_t offset) {
  if (const auto own = mark_at(text, line_end(text, offset)); !own.empty()) return own;
  uint32_t begin = line_begin(text, offset);
  if (begin > 0 && is_line_mark(text[begin - 1])) {
    const bool both = begin > 1 && text[begin - 1] == '\n' && text[begin - 2] == '\r';
    return text.substr(begin - (both ? 2 : 1), both ? 2 : 1);
  }
  if (const auto first = mark_at(text, line_end(text, 0)); !first.empty()) return first;
  return "\n";
}

std::string indentation_unit(std::string_view text, std::string_view usual) {
  constexpr size_t kFarEnough = 1 << 16;
  const std::string_view part = text.substr(0, kFarEnough);
  for (uint32_t at = 0; at < part.size(); at = next_line(part, at)) {
    const std::string_view blanks = indentation(part, at);
    if (blanks.empty() || at + blanks.size() >= part.size()) continue;
    const char first = part[at + blanks.size()];
    if (is_line_mark(first) || first == '#' || first == '*') continue;
    if (blanks.front() == '\t') return "\t";
    if (blanks.size() <= 8) return std::string(blanks);
  }
  return std::string(usual);
}

LineColumn line_column(std::string_view text, uint32_t offset) {
  const uint32_t begin = line_begin(text, offset);
  uint32_t line = 1;
  for (uint32_t at = 0; at < begin;) {
    at = next_line(text, at);
    if (at <= begin) ++line;
  }
  return {line, clamped(text, offset) - begin + 1};
}

}  // namespace tessera::edit
