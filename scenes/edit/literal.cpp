#include "scenes/edit/literal.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "base/error.h"

namespace tessera::edit {
namespace {

std::string shown(std::string_view typed) {
  constexpr size_t kLongest = 40;
  if (trimmed(typed).empty()) return "nothing";
  return typed.size() > kLongest ? fmt::format("'{}...'", typed.substr(0, kLongest))
                                 : fmt::format("'{}'", typed);
}

Refusal refused(std::string_view typed, std::string expected) {
  return {shown(typed), std::move(expected), {}};
}

std::string expected_number(const Field& field) {
  std::string kind = field.kind == ValueKind::integer ? "an integer" : "a number such as 1.5";
  const std::string limits = field.limits.str();
  return limits.empty() ? kind : fmt::format("{}, {}", kind, limits);
}

std::optional<Refusal> check_number(const Field& field, std::string_view typed) {
  const auto value = typed_number(trimmed(typed));
  const std::string expected = expected_number(field);
  if (!value) return refused(typed, expected);
  const bool is_whole = std::all_of(trimmed(typed).begin(), trimmed(typed).end(), [](char c) {
    return ('0' <= c && c <= '9') || c == '-' || c == '+';
  });
  if (field.kind == ValueKind::integer && !is_whole) return refused(typed, expected);
  if (!field.limits.allows(*value)) return refused(typed, expected);
  return {};
}

std::optional<Refusal> check_choice(const Field& field, std::string_view typed) {
  const std::string word(trimmed(typed));
  if (std::find(field.choices.begin(), field.choices.end(), word) != field.choices.end()) return {};
  return refused(typed, fmt::format("one of {}{}", fmt::join(field.choices, ", "),
                                    suggestion(word, field.choices)));
}

bool is_utf8(std::string_view text) {
  for (size_t i = 0; i < text.size();) {
    const auto c = static_cast<unsigned char>(text[i]);
    const size_t size = c < 0x80                ? 1
                        : c >= 0xC2 && c < 0xE0 ? 2
                        : c >= 0xE0 && c < 0xF0 ? 3
                        : c >= 0xF0 && c < 0xF5 ? 4
                                                : 0;
    if (size == 0 || i + size > text.size()) return false;
    for (size_t k = 1; k < size; ++k)
      if ((static_cast<unsigned char>(text[i + k]) & 0xC0) != 0x80) return false;
    const auto second = size > 1 ? static_cast<unsigned char>(text[i + 1]) : 0x80;
    if ((c == 0xE0 && second < 0xA0) || (c == 0xED && second > 0x9F) ||
        (c == 0xF0 && second < 0x90) || (c == 0xF4 && second > 0x8F))
      return false;
    i += size;
  }
  return true;
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

std::optional<double> typed_number(std::string_view text) {
  if (text.starts_with('+') && text.size() > 1 && text[1] != '-' && text[1] != '+')
    text.remove_prefix(1);
  if (text.empty() || text.find_first_not_of("+-.0123456789eE") != std::string_view::npos)
    return {};
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (stop != end || error == std::errc::invalid_argument) return {};
  // What is too small to be told from zero is zero.
  if (error == std::errc::result_out_of_range) {
    const size_t exponent = text.find_first_of("eE");
    if (exponent == std::string_view::npos || text[exponent + 1] != '-') return {};
    return 0;
  }
  return value;
}

std::optional<Refusal> check_value(const Field& field, std::string_view typed) {
  switch (field.kind) {
    case ValueKind::number:
    case ValueKind::integer:
      return check_number(field, typed);
    case ValueKind::boolean:
    case ValueKind::choice:
      return check_choice(field, typed);
    case ValueKind::text:
    case ValueKind::file:
    case ValueKind::reference:
      if (!is_utf8(typed)) return refused("bytes that are no text", "text in UTF-8");
      if (typed.find('\0') != std::string_view::npos)
        return refused("a zero byte", "text in UTF-8");
      return {};
    case ValueKind::data:
    case ValueKind::expression:
      return refused(field.name, field.locked.empty() ? "a field that can be set" : field.locked);
    default:
      return {};
  }
}

std::vector<std::string> typed_parts(std::string_view typed) {
  std::vector<std::string> parts;
  std::string part;
  for (size_t i = 0; i <= typed.size(); ++i) {
    const bool ends = i == typed.size() || is_space(typed[i]);
    if (!ends) {
      part += typed[i];
      continue;
    }
    if (part.ends_with(',') && part.size() > 1) part.pop_back();
    if (!part.empty()) parts.push_back(std::move(part));
    part.clear();
  }
  return parts;
}

std::string strict_number(std::string_view number) {
  std::string made(number.starts_with('+') ? number.substr(1) : number);
  const size_t first = made.starts_with('-') ? 1 : 0;
  if (made.size() > first && made[first] == '.') made.insert(first, "0");
  const size_t point = made.find('.');
  const bool ends_there =
      point + 1 == made.size() ||
      (point != std::string::npos && (made[point + 1] == 'e' || made[point + 1] == 'E'));
  if (point != std::string::npos && ends_there) made.erase(point, 1);
  size_t digits = first;
  while (digits + 1 < made.size() && made[digits] == '0' && '0' <= made[digits + 1] &&
         made[digits + 1] <= '9')
    made.erase(digits, 1);
  return made;
}

std::string shortest_number(double value, double tolerance) {
  if (!(std::abs(value) > tolerance)) return "0";
  std::string best;
  for (int digits = 1; digits <= std::numeric_limits<double>::max_digits10; ++digits) {
    best = fmt::format("{:.{}g}", value, digits);
    double back = 0;
    std::from_chars(best.data(), best.data() + best.size(), back);
    if (std::abs(back - value) <= tolerance) break;
  }
  double kept = 0;
  std::from_chars(best.data(), best.data() + best.size(), kept);
  std::string plain = fmt::format("{}", kept);
  if (plain.ends_with(".0")) plain.resize(plain.size() - 2);
  return plain.size() <= best.size() ? plain : best;
}

std::string free_name(std::string_view name, const std::vector<std::string>& taken,
                      std::string_view blank) {
  const auto is_taken = [&](const std::string& asked) {
    return std::find(taken.begin(), taken.end(), asked) != taken.end();
  };
  std::string made(name);
  std::string stem = made;
  while (!stem.empty() && '0' <= stem.back() && stem.back() <= '9') stem.pop_back();
  if (!blank.empty() && stem.size() < made.size() && !stem.ends_with(blank)) stem = made;
  if (!blank.empty() && stem.ends_with(blank) && stem.size() < made.size())
    stem.resize(stem.size() - blank.size());
  for (int i = 2; is_taken(made); ++i) made = fmt::format("{}{}{}", stem, blank, i);
  return made;
}

}  // namespace tessera::edit
