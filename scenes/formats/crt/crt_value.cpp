#include "scenes/formats/crt/crt_value.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace tessera {

void CrtHeap::charge(uint64_t bytes, CrtSpan where) {
  bytes_ += bytes;
  if (bytes_ > kMaxBytes)
    throw CrtLimitError(where, "the script needs too much memory",
                        fmt::format("at most {} MiB", kMaxBytes >> 20));
}

const std::string* CrtHeap::text(std::string value, CrtSpan where) {
  charge(64 + value.size(), where);
  return &std::get<std::deque<std::string>>(pools_).emplace_back(std::move(value));
}

const CrtList* CrtHeap::list(std::vector<CrtValue> items, CrtSpan where) {
  charge(64 + items.size() * sizeof(CrtValue), where);
  return &std::get<std::deque<CrtList>>(pools_).emplace_back(CrtList{std::move(items)});
}

std::string_view type_name(const CrtValue& value) {
  static constexpr std::array<std::string_view, 16> kNames{
      "nothing",  "nothing",      "an integer", "a float",   "a boolean", "a text",
      "a vector", "a colour",     "a list",     "an entity", "a light",   "a material",
      "a camera", "a background", "a texture",  "a macro"};
  static_assert(std::variant_size_v<CrtValue> == kNames.size());
  return kNames[value.index()];
}

std::string describe(const CrtValue& value) {
  constexpr size_t kLongest = 32;
  if (holds<int32_t>(value)) return fmt::format("the integer {}", number_text(value));
  if (holds<double>(value)) return fmt::format("the float {}", number_text(value));
  if (holds<bool>(value)) return std::get<bool>(value) ? "true" : "false";
  if (holds<const std::string*>(value)) {
    const std::string& text = *std::get<const std::string*>(value);
    if (text.size() <= kLongest) return fmt::format("the text \"{}\"", text);
  }
  return std::string(type_name(value));
}

double number_of(const CrtValue& value) {
  return holds<int32_t>(value) ? std::get<int32_t>(value) : std::get<double>(value);
}

std::optional<int32_t> whole_number(const CrtValue& value) {
  if (holds<int32_t>(value)) return std::get<int32_t>(value);
  if (!holds<double>(value)) return std::nullopt;
  const double number = std::get<double>(value);
  if (number != std::floor(number) || std::abs(number) >= 1e9) return std::nullopt;
  return static_cast<int32_t>(number);
}

std::string number_text(const CrtValue& value) {
  if (holds<int32_t>(value)) return fmt::format("{}", std::get<int32_t>(value));
  const double number = std::get<double>(value);
  if (!std::isfinite(number))
    return std::isnan(number) ? "NaN" : number > 0 ? "Infinity" : "-Infinity";
  // The fewest digits that tell it, with a point: with an exponent below 10^-3 and from 10^7 on.
  const double size = std::abs(number);
  const bool is_short = number == 0 || (size >= 1e-3 && size < 1e7);
  std::array<char, 400> digits;
  const auto written =
      std::to_chars(digits.data(), digits.data() + digits.size(), number,
                    is_short ? std::chars_format::fixed : std::chars_format::scientific);
  const std::string_view all(digits.data(), written.ptr);
  const size_t end = std::min(all.find('e'), all.size());
  std::string text(all.substr(0, end));
  if (text.find('.') == std::string::npos) text += ".0";
  if (is_short) return text;
  return fmt::format("{}E{}", text, std::stoi(std::string(all.substr(end + 1))));
}

}  // namespace tessera
