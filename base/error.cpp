#include "base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <numeric>
#include <utility>
#include <vector>

#include "base/lower_case.h"
#include "base/plain_text.h"

namespace tessera {

std::string SourcePlace::str() const {
  if (line <= 0) return file;
  if (column <= 0) return fmt::format("{}:{}", file, line);
  return fmt::format("{}:{}:{}", file, line, column);
}

namespace {

constexpr std::string_view kExpected = "; expected ";
constexpr std::string_view kSuggested = "; did you mean '", kSuggestionEnd = "'?";

/// Takes what suggestion() gave off the end of `text`, and returns the name in it.
std::string take_suggestion(std::string_view& text) {
  const size_t at = text.rfind(kSuggested);
  if (at == std::string_view::npos || !text.ends_with(kSuggestionEnd)) return "";
  std::string_view name = text.substr(at + kSuggested.size());
  if (name.size() < kSuggestionEnd.size()) return "";
  name.remove_suffix(kSuggestionEnd.size());
  text = text.substr(0, at);
  return std::string(name);
}

bool is_in_word(char c) {
  const auto byte = static_cast<unsigned char>(c);
  return std::isalnum(byte) || c == '_' || byte >= 0x80;
}

/// The length of what begins at the first byte of `text`, which is not empty.
size_t word_length(std::string_view text) {
  const char first = text.front();
  if (first == '"' || first == '\'') {
    for (size_t at = 1; at < text.size() && text[at] != '\n' && text[at] != '\r'; ++at) {
      if (text[at] == '\\') {
        ++at;
      } else if (text[at] == first) {
        return at + 1;
      }
    }
    return 1;
  }
  size_t length = std::string_view("+-.").find(first) != std::string_view::npos ? 1 : 0;
  while (length < text.size() && (is_in_word(text[length]) || text[length] == '.')) {
    const bool exponent = (text[length] == 'e' || text[length] == 'E') &&
                          text.size() > length + 2 &&
                          std::isdigit(static_cast<unsigned char>(text[length + 2])) &&
                          std::isdigit(static_cast<unsigned char>(text[length - (length > 0)]));
    length += exponent && (text[length + 1] == '-' || text[length + 1] == '+') ? 2 : 1;
  }
  return std::max<size_t>(length, 1);
}

}  // namespace

Diagnostic make_diagnostic(SourcePlace place, std::string_view found, std::string_view expected) {
  Diagnostic out{.place = std::move(place), .found = {}};
  if (expected.empty()) {
    out.suggestion = take_suggestion(found);
    const size_t at = found.find(kExpected);
    if (at != std::string_view::npos) {
      expected = found.substr(at + kExpected.size());
      found = found.substr(0, at);
    }
  } else {
    out.suggestion = take_suggestion(expected);
  }
  out.found = escape_controls(found, true);
  out.expected = escape_controls(expected, true);
  return out;
}

SourcePlace end_of_word(std::string_view text, const SourcePlace& place) {
  if (place.line < 1 || place.column < 1) return {};
  size_t at = 0;
  for (int line = 1; line < place.line; ++line) {
    const size_t end = text.find_first_of("\r\n", at);
    if (end == std::string_view::npos) return {};
    at = end + (text.substr(end, 2) == "\r\n" ? 2 : 1);
  }
  const size_t line_end = std::min(text.find_first_of("\r\n", at), text.size());
  at += static_cast<size_t>(place.column) - 1;
  if (at > line_end) return {};
  SourcePlace end = place;
  if (at < line_end) end.column += static_cast<int>(word_length(text.substr(at, line_end - at)));
  return end;
}

Error scene_error(const SourcePlace& place, std::string_view found, std::string_view expected) {
  const std::string where = place.file.empty() ? "" : place.str() + ": ";
  return Error(ExitCode::bad_scene,
               escape_controls(fmt::format("{}{}{}{}", where, found,
                                           expected.empty() ? "" : kExpected, expected)),
               {make_diagnostic(place, found, expected)});
}

Error scene_error(std::string_view message, std::vector<Diagnostic> diagnostics) {
  return Error(ExitCode::bad_scene, escape_controls(message, true), std::move(diagnostics));
}

Error usage_error(std::string_view message) {
  return Error(ExitCode::bad_usage, escape_controls(message, true));
}

Error render_error(std::string_view message) {
  return Error(ExitCode::render_failed, escape_controls(message, true));
}

Error temporary_error(std::string_view message) {
  return Error(ExitCode::try_again, escape_controls(message, true));
}

ExitCode to_exit_code(uint32_t number) {
  const auto code = static_cast<ExitCode>(number);
  switch (code) {
    case ExitCode::done:
    case ExitCode::bad_scene:
    case ExitCode::bad_usage:
    case ExitCode::render_failed:
    case ExitCode::interrupted:
    case ExitCode::try_again:
      return code;
  }
  return ExitCode::render_failed;
}

bool is_temporary(int error) {
  constexpr int kTemporary[] = {EMFILE, ENFILE,   ENOMEM,    ENOBUFS,  ENOSPC, EDQUOT,
                                EFBIG,  EIO,      EACCES,    EPERM,    EROFS,  EAGAIN,
                                EBUSY,  ETXTBSY,  EINTR,     ESTALE,   ENXIO,  ENODEV,
                                ENOLCK, ENOTCONN, ETIMEDOUT, EHOSTDOWN};
  return std::ranges::find(kTemporary, error) != std::end(kTemporary);
}

namespace {

/// Edits from `a` to `b` without regard to case, where two neighbours that changed places count as
/// one: the commonest slip (optimal string alignment), by rows of the table.
size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<size_t> before_last, last, row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  const auto equal = [&](size_t i, size_t j) { return lower_case(a[i]) == lower_case(b[j]); };
  for (size_t i = 0; i < a.size(); ++i) {
    before_last = std::exchange(last, row);
    row[0] = i + 1;
    for (size_t j = 0; j < b.size(); ++j) {
      row[j + 1] = std::min({last[j] + (equal(i, j) ? 0 : 1), last[j + 1] + 1, row[j] + 1});
      if (i > 0 && j > 0 && equal(i, j - 1) && equal(i - 1, j)) {
        row[j + 1] = std::min(row[j + 1], before_last[j - 1] + 1);
      }
    }
  }
  return row.back();
}

/// Whether each character of `name` is in `whole`, in that order.
bool is_in_order(std::string_view name, std::string_view whole) {
  size_t found = 0;
  for (const char c : whole) {
    if (found < name.size() && lower_case(c) == lower_case(name[found])) ++found;
  }
  return found == name.size();
}

/// Whether a word of `text` begins so.
bool has_word(std::string_view text, std::string_view beginning) {
  for (size_t at = 0; at + beginning.size() <= text.size(); ++at) {
    const bool begins = at == 0 || std::string_view("-_ ").find(text[at - 1]) != text.npos;
    if (begins && edit_distance(text.substr(at, beginning.size()), beginning) == 0) return true;
  }
  return false;
}

/// Whether one name is the beginning or a word of the other, or is the other with letters left out.
bool is_short_for(std::string_view name, std::string_view candidate) {
  constexpr size_t kShortest = 3;
  if (std::min(name.size(), candidate.size()) < kShortest) return false;
  const bool same_letter = lower_case(name.front()) == lower_case(candidate.front());
  const bool lacks_letters = same_letter && 2 * name.size() > candidate.size();
  return has_word(candidate, name) ||
         edit_distance(name.substr(0, candidate.size()), candidate) == 0 ||
         (lacks_letters && is_in_order(name, candidate));
}

}  // namespace

std::optional<std::string> nearest_name(std::string_view name,
                                        std::span<const std::string> candidates) {
  constexpr size_t kLongestName = 256;
  if (name.size() > kLongestName) return std::nullopt;
  const std::string* best = nullptr;
  // A name of one letter is never like another by its letters alone.
  size_t best_distance = std::min(std::max<size_t>(1, (name.size() + 1) / 3) + 1, name.size());
  for (const std::string& candidate : candidates) {
    if (candidate.size() > kLongestName) continue;
    const size_t distance = edit_distance(name, candidate);
    if (distance < best_distance) {
      best_distance = distance;
      best = &candidate;
    }
  }
  if (best) return *best;
  for (const std::string& candidate : candidates) {
    if (candidate.size() <= kLongestName && is_short_for(name, candidate)) return candidate;
  }
  return std::nullopt;
}

std::string suggestion(std::string_view name, std::span<const std::string> candidates) {
  const auto nearest = nearest_name(name, candidates);
  return nearest ? fmt::format("{}{}{}", kSuggested, *nearest, kSuggestionEnd) : "";
}

void check_failed(const char* file, int line, const char* condition, const std::string& values) {
  std::fprintf(stderr, "%s:%d: broken promise: %s (%s)\n", file, line, condition, values.c_str());
  std::abort();
}

}  // namespace tessera
