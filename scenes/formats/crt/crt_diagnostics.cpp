#include "scenes/formats/crt/crt_diagnostics.h"

#include <fmt/format.h>

#include <algorithm>

#include "scenes/import/warnings.h"

namespace tessera {
namespace {

constexpr size_t kWidestExcerpt = 96;

bool starts_character(char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }

/// Characters, not bytes: what an editor counts.
size_t characters(std::string_view text) {
  return static_cast<size_t>(std::count_if(text.begin(), text.end(), starts_character));
}

}  // namespace

CrtDiagnostics::CrtDiagnostics(std::string file, std::string_view text)
    : file_(std::move(file)), text_(text), line_starts_{0} {
  for (size_t i = 0; i < text.size(); ++i) {
    const bool ends = text[i] == '\n' || (text[i] == '\r' && text.substr(i + 1, 1) != "\n");
    if (ends) line_starts_.push_back(static_cast<uint32_t>(i + 1));
  }
}

void CrtDiagnostics::error(CrtSpan where, std::string_view found, std::string_view expected) {
  if (is_full() || !error_places_.insert(where.offset).second) return;
  std::string text = scene_error(place(where), found, expected).what();
  errors_.push_back({where, text + "\n" + excerpt(where), parts_of(where, found, expected)});
}

void CrtDiagnostics::warning(CrtSpan where, std::string_view what) {
  if (!warning_places_.insert(where.offset).second) return;
  if (warnings_.size() == kMostWarnings) {
    ++warnings_dropped_;
    return;
  }
  warnings_.push_back(
      {where, fmt::format("{}: {}", place(where).str(), what), parts_of(where, what, "")});
}

void CrtDiagnostics::throw_if_any() const {
  if (errors_.empty()) return;
  std::vector<Message> sorted = errors_;
  std::stable_sort(sorted.begin(), sorted.end(), [](const Message& a, const Message& b) {
    return a.where.offset < b.where.offset;
  });
  std::string all;
  std::vector<Diagnostic> parts;
  for (const Message& message : sorted) {
    all += message.text + "\n";
    parts.push_back(message.parts);
  }
  if (is_full())
    all += fmt::format("{} errors; the rest is not looked at", errors_.size());
  else if (errors_.size() > 1)
    all += fmt::format("{} errors", errors_.size());
  else
    all.pop_back();
  throw scene_error(all, std::move(parts));
}

void CrtDiagnostics::add_warnings_to(LoadedScene& loaded) const {
  for (const Message& message : warnings_) {
    loaded.warnings.push_back(message.text);
    loaded.warning_diagnostics.push_back(message.parts);
  }
  if (warnings_dropped_) add_warning(loaded, file_, fmt::format("{} more", warnings_dropped_));
}

SourcePlace CrtDiagnostics::byte_place(uint32_t offset) const {
  const auto next = std::upper_bound(line_starts_.begin(), line_starts_.end(), offset);
  const auto line = static_cast<size_t>(next - line_starts_.begin());
  return {file_, static_cast<int>(line), static_cast<int>(offset - line_starts_[line - 1]) + 1};
}

Diagnostic CrtDiagnostics::parts_of(CrtSpan where, std::string_view found,
                                    std::string_view expected) const {
  Diagnostic parts = make_diagnostic(byte_place(where.offset), found, expected);
  if (where.length > 0) parts.end = byte_place(where.offset + where.length);
  return parts;
}

SourcePlace CrtDiagnostics::place(CrtSpan where) const {
  const auto next = std::upper_bound(line_starts_.begin(), line_starts_.end(), where.offset);
  const auto line = static_cast<size_t>(next - line_starts_.begin());
  const uint32_t start = line_starts_[line - 1];
  return {file_, static_cast<int>(line),
          static_cast<int>(characters(text_.substr(start, where.offset - start))) + 1};
}

std::string CrtDiagnostics::excerpt(CrtSpan where) const {
  const SourcePlace at = place(where);
  const size_t start = line_starts_[static_cast<size_t>(at.line) - 1];
  std::string_view line = text_.substr(start, text_.find_first_of("\r\n", start) - start);
  size_t caret = std::min<size_t>(where.offset - start, line.size());
  if (line.size() > kWidestExcerpt) {
    // The window moves with the caret and starts where a character does.
    size_t from = caret > kWidestExcerpt / 2 ? caret - kWidestExcerpt / 2 : 0;
    while (from < caret && !starts_character(line[from])) ++from;
    size_t to = std::min(line.size(), from + kWidestExcerpt);
    while (to < line.size() && !starts_character(line[to])) ++to;
    line = line.substr(from, to - from);
    caret -= from;
  }
  std::string shown(line);
  for (char& c : shown)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = c == '\t' ? ' ' : '?';
  const size_t before = characters(line.substr(0, caret));
  const size_t marked = characters(line.substr(caret, std::max<uint32_t>(where.length, 1)));
  return fmt::format("{:5} | {}\n      | {:{}}{:^>{}}", at.line, shown, "", before, "",
                     std::max<size_t>(marked, 1));
}

}  // namespace tessera
