#pragma once

#include <cstdint>

namespace tessera {

/// The linear value of an sRGB-encoded one, 0 to 1 (IEC 61966-2-1). The same bits on every host.
double srgb_to_linear(double value);

/// IEEE 754 binary16, exactly; infinities and NaN too.
float half_to_float(uint16_t half);
/// Whether it is neither infinite nor NaN.
constexpr bool is_finite_half(uint16_t half) { return (half & 0x7c00) != 0x7c00; }
/// The nearest half, ties to even; infinity beyond the largest one.
uint16_t float_to_half(float value);

}  // namespace tessera
