#include "renderer/math/encodings.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "renderer/math/elementary.h"

namespace tessera {

double srgb_to_linear(double value) {
  return value <= 0.04045 ? value / 12.92 : portable::pow((value + 0.055) / 1.055, 2.4);
}

float half_to_float(uint16_t half) {
  // As a float's fields; the factor is between the two kinds' biases, and sets subnormals right.
  float size = std::bit_cast<float>((half & 0x7fffu) << 13) * 0x1p112f;
  if ((half & 0x7c00) == 0x7c00)
    size = std::bit_cast<float>(std::bit_cast<uint32_t>(size) | 0x7f800000u);
  return half & 0x8000 ? -size : size;
}

uint16_t float_to_half(float value) {
  const uint32_t sign = (std::bit_cast<uint32_t>(value) >> 16) & 0x8000;
  if (std::isnan(value)) return static_cast<uint16_t>(sign | 0x7e00);
  const float size = std::abs(value);
  if (size == 0) return static_cast<uint16_t>(sign);
  if (size >= 65520) return static_cast<uint16_t>(sign | 0x7c00);
  int exponent;
  std::frexp(size, &exponent);  // size = m 2^exponent, m in [.5, 1)
  const int step = std::max(exponent - 11, -24);
  const auto steps = static_cast<uint32_t>(std::nearbyint(std::ldexp(size, -step)));
  // A carry out of the mantissa goes on into the exponent, as it should.
  return static_cast<uint16_t>(sign | (static_cast<uint32_t>(step + 24) * 1024 + steps));
}

}  // namespace tessera
