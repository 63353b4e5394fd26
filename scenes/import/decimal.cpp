#include "scenes/import/decimal.h"

#include <cmath>

namespace tessera {
namespace {

/// Where the library is to begin: behind a plus that no other sign follows.
const char* behind_plus(const char* begin, const char* end) {
  const bool has_plus = end - begin > 1 && *begin == '+' && begin[1] != '-';
  return has_plus ? begin + 1 : begin;
}

}  // namespace

std::from_chars_result read_decimal(const char* begin, const char* end, double& value) {
  return std::from_chars(behind_plus(begin, end), end, value);
}

std::from_chars_result read_unusual_decimal(const char* begin, const char* end, float& value) {
  begin = behind_plus(begin, end);
  const std::from_chars_result read = std::from_chars(begin, end, value);
  if (read.ec != std::errc::result_out_of_range) return read;
  double wide = 0;
  const std::from_chars_result again = std::from_chars(begin, end, wide);
  if (again.ec != std::errc() || std::abs(wide) >= 1) return read;
  value = static_cast<float>(wide);
  return again;
}

}  // namespace tessera
