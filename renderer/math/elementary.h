#pragma once

namespace tessera::portable {

// Elementary functions whose bits are the same on every host, at most 1 ulp from the exact value
// over the ranges stated. The C library picks other code (with or without fused multiply-add) by
// the processor, so whatever reaches a pixel uses these; square root and division are exact
// everywhere and need no twin. Thread-safe, never allocate.

double sin(double x);   ///< |x| <= 1e6
double cos(double x);   ///< |x| <= 1e6
double tan(double x);   ///< |x| <= 1e6
double asin(double x);  ///< |x| <= 1; NaN outside
double acos(double x);  ///< |x| <= 1; NaN outside
double atan(double x);
double atan2(double y, double x);  ///< also a lane each in lanes-inl.h, bit for bit
double exp(double x);
double log(double x);            ///< x >= 0
double pow(double x, double y);  ///< x >= 0; pow(x, 0) is 1

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double radians(double degrees) { return degrees * (kPi / 180); }
inline constexpr double degrees(double radians) { return radians * (180 / kPi); }

}  // namespace tessera::portable
