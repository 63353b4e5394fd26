#pragma once

#include <array>
#include <bit>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace tessera {

/// 10^i.
inline constexpr std::array<double, 16> kShortPowersOf10{
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};

/// read_decimal() of what is not short.
std::from_chars_result read_unusual_decimal(const char* begin, const char* end, float& value);

/// Reads what nearly every number of a text of meshes is: digits with or without a point and a sign
/// before them, at most 15, no exponent. Returns where it ends, with the nearest float in `value`;
/// null, with `value` as it was, where std::from_chars(), which takes five times as long, has to
/// look: at anything else, and at numbers on or beside the border between two floats.
inline const char* read_short_decimal(const char* at, const char* end, float& value) {
  const bool is_negative = at != end && *at == '-';
  if (is_negative) ++at;
  uint64_t number = 0;  // of many digits it is something else, and not looked at
  const auto read_digits = [&] {
    const char* const first = at;
    for (; at != end && *at >= '0' && *at <= '9'; ++at) {
      number = number * 10 + static_cast<uint64_t>(*at - '0');
    }
    return at - first;
  };
  auto digits = read_digits();
  decltype(digits) after_point = 0;
  if (at != end && *at == '.') {
    ++at;
    after_point = read_digits();
    digits += after_point;
  }
  const bool has_exponent = at != end && (*at == 'e' || *at == 'E');
  constexpr int kMostDigits = 15;
  if (digits == 0 || digits > kMostDigits || has_exponent) return nullptr;
  // Of whole numbers below 2^53, so that it is the nearest double.
  const double quotient = static_cast<double>(static_cast<int64_t>(number)) /
                          kShortPowersOf10[static_cast<size_t>(after_point)];
  // The nearest float to a number is the nearest to its nearest double, unless that lies just
  // between two floats, which are normal.
  constexpr uint64_t kRest = (uint64_t{1} << 29) - 1, kBetween = uint64_t{1} << 28;
  if ((std::bit_cast<uint64_t>(quotient) & kRest) == kBetween) return nullptr;
  if (number != 0 && quotient < double{std::numeric_limits<float>::min()}) return nullptr;
  value = static_cast<float>(is_negative ? -quotient : quotient);
  return at;
}

/// std::from_chars() for what files of scenes have: a plus before the number too, though no second
/// sign, and what is too small for a float is as good as zero, not out of range. `value` is as it
/// was where there is no number, or one that is out of range.
inline std::from_chars_result read_decimal(const char* begin, const char* end, float& value) {
  if (const char* const stop = read_short_decimal(begin, end, value)) return {stop, std::errc()};
  return read_unusual_decimal(begin, end, value);
}
std::from_chars_result read_decimal(const char* begin, const char* end, double& value);

}  // namespace tessera
