#pragma once

#include <cmath>
#include <limits>
#include <string_view>

#include "scenes/import/decimal.h"

namespace tessera {

/// Reads a number, which single precision can hold. Returns the rule that the word breaks, or null.
/// The value is then the nearest one in the range, or NaN for what is no finite number.
template <typename Number>
const char* read_x3d_number(std::string_view word, Number& value) {
  constexpr double kTooLarge = 0x1.ffffffp127;  // what single precision rounds to infinity
  const char* const end = word.data() + word.size();
  const auto [stop, problem] = read_decimal(word.data(), end, value);
  const bool is_number = stop == end && problem != std::errc::invalid_argument;
  const bool is_large = is_number && (problem == std::errc::result_out_of_range ||
                                      (std::abs(value) >= kTooLarge && std::isfinite(value)));
  if (is_large) {
    constexpr Number kLargest = std::numeric_limits<float>::max();
    value = word.starts_with('-') ? -kLargest : kLargest;
    return "a number in the range of single precision";
  }
  if (is_number && std::isfinite(value)) return nullptr;
  value = std::numeric_limits<Number>::quiet_NaN();
  return is_number ? "a finite number" : "a number";
}

}  // namespace tessera
