#pragma once

#include <cstdint>

#include "renderer/math/vec.h"

namespace tessera {

// Gradient noise (Perlin 2002, "Improving Noise"), its lattice hashed from integers instead of
// taken from a table, so that it never repeats. The bits are the same on every host.

/// In [-1, 1], 0 at every lattice point, with continuous second derivatives. Any finite point.
double gradient_noise(const Vec3& p);

/// The sum of `octaves` noises, each at twice the frequency and half the strength of the one
/// before. Octaves finer than a patch of `width` (in units of p) fade out.
double fractal_noise(const Vec3& p, uint32_t octaves, double width);

/// The same of the noise's absolute value; finer octaves fade to their mean.
double turbulence(const Vec3& p, uint32_t octaves, double width);

}  // namespace tessera
