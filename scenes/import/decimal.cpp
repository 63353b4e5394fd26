#include "scenes/import/decimal.h"

#include <cmath>

namespace tessera {
namespace {

/// Where the library is to begin: behind a plus that no other sign follows.
const char* behind_plus(const char* begin, const char* end) {
  const bool has_plus = end - begin > 1 && *begin == '+' && begin[1] != '-';
  return has_plus ? begin + 1 : begin;
}

/// Of a number that no double comes near, and that ends at `end`: whether it is too small. Where
/// its first digit stands that is not 0 says that, with the exponent: no text is so long that it is
/// in doubt.
bool is_too_small(const char* at, const char* end) {
  int64_t place = 0;  // of the first digit: 1 for units, 0 for tenths
  bool has_digit = false, is_behind_point = false;
  for (; at != end && *at != 'e' && *at != 'E'; ++at) {
    if (*at == '.') is_behind_point = true;
    if (*at < '0' || *at > '9') continue;
    has_digit |= *at != '0';
    if (!is_behind_point && has_digit) ++place;
    if (is_behind_point && !has_digit) --place;
  }
  if (at == end) return place <= 0;
  const bool is_negative = *++at == '-';
  if (*at == '-' || *at == '+') ++at;
  int64_t exponent = 0;
  const bool fits = std::from_chars(at, end, exponent).ec == std::errc();
  return fits ? place + (is_negative ? -exponent : exponent) <= 0 : is_negative;
}

}  // namespace

std::from_chars_result read_decimal(const char* begin, const char* end, double& value) {
  begin = behind_plus(begin, end);
  std::from_chars_result read = std::from_chars(begin, end, value);
  if (read.ec != std::errc::result_out_of_range || !is_too_small(begin, read.ptr)) return read;
  value = *begin == '-' ? -0.0 : 0.0;
  return {read.ptr, std::errc()};
}

std::from_chars_result read_unusual_decimal(const char* begin, const char* end, float& value) {
  begin = behind_plus(begin, end);
  const std::from_chars_result read = std::from_chars(begin, end, value);
  if (read.ec != std::errc::result_out_of_range) return read;
  double wide = 0;
  const std::from_chars_result again = read_decimal(begin, end, wide);
  if (again.ec != std::errc() || std::abs(wide) >= 1) return read;
  value = static_cast<float>(wide);
  return again;
}

}  // namespace tessera
