#pragma once

#include <gtest/gtest.h>
#include <pthread.h>
#include <quadmath.h>

#include <cmath>
#include <concepts>
#include <cstdint>
#include <cstdlib>
#include <limits>

#include "renderer/math/elementary.h"
#include "renderer/math/precise_vec.h"
#include "renderer/math/transform.h"
#include "tests/sanitizers.h"

namespace tessera::numerics {

// What all tests of numerics share: random numbers, ray counts, arithmetic in quad precision.

/// Rays, scenes or the like to try where the full test tries `full`: all of them with
/// TESSERA_NUMERICS_FULL=1 in the environment, else one hundredth.
inline int64_t ray_count(int64_t full) {
  static const bool all = [] {
    const char* text = std::getenv("TESSERA_NUMERICS_FULL");
    return text && text[0] == '1';
  }();
  return all ? full : (full + 99) / 100;
}
/// The same of those that take longest: fewer where a sanitizer looks on.
inline int64_t long_ray_count(int64_t full) {
  return kSanitized ? (ray_count(full) + 9) / 10 : ray_count(full);
}

/// Runs work(argument) in a thread of 1 MiB of stack.
inline void run_on_small_stack(void* (*work)(void*), void* argument) {
  pthread_attr_t attributes;
  ASSERT_EQ(pthread_attr_init(&attributes), 0);
  ASSERT_EQ(pthread_attr_setstacksize(&attributes, 1 << 20), 0);
  pthread_t thread;
  ASSERT_EQ(pthread_create(&thread, &attributes, work, argument), 0);
  pthread_join(thread, nullptr);
}

/// A test in shards of one seed each, which CTest runs in parallel: with
///   using N01 = Shard;
///   TEST_P(N01, Name) { ... seed() ... }
///   INSTANTIATE_TEST_SUITE_P(Seed, N01, kSeeds);
/// each shard does `ray_count(full / kShards)`.
class Shard : public testing::TestWithParam<uint64_t> {
 protected:
  uint64_t seed() const { return GetParam(); }
};
inline constexpr int64_t kShards = 8;
inline const auto kSeeds = testing::Range<uint64_t>(1, kShards + 1);

/// PCG32 (O'Neill 2014): stream = test id, seed 1 to 8; a failure that names both can be replayed.
class Random {
 public:
  explicit Random(uint64_t stream, uint64_t seed = 1) : increment_(2 * stream + 1) {
    next();
    state_ += seed;
    next();
  }
  uint32_t next() {
    const uint64_t old = state_;
    state_ = old * 6364136223846793005u + increment_;
    const auto shifted = static_cast<uint32_t>(((old >> 18) ^ old) >> 27);
    const auto turn = static_cast<uint32_t>(old >> 59);
    return (shifted >> turn) | (shifted << ((32 - turn) & 31));
  }
  /// In [0, 1), 53 bits.
  double uniform() {
    const uint64_t high = next();
    return static_cast<double>((high << 21) ^ (next() >> 11)) * 0x1p-53;
  }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// +-10^[low, high].
  double power(double low, double high) {
    const double size = std::pow(10.0, uniform(low, high));
    return next() & 1 ? size : -size;
  }
  template <std::integral T>
  T below(T n) {
    return static_cast<T>(next() % static_cast<uint32_t>(n));
  }
  Vec3 direction() {
    const double z = uniform(-1, 1), turn = uniform(0, 2 * portable::kPi);
    const double r = std::sqrt(1 - z * z);
    return normalize(Vec3{r * std::cos(turn), r * std::sin(turn), z});
  }
  Vec3 in_cube(double half) {
    const double x = uniform(-half, half), y = uniform(-half, half);
    return {x, y, uniform(-half, half)};
  }
  Affine turn() { return rotation(direction(), uniform(0, 6.28)); }

 private:
  uint64_t state_ = 0;
  uint64_t increment_;
};

using Quad = __float128;
inline constexpr Quad kQuadInfinity = std::numeric_limits<double>::infinity();

using QuadVec = PreciseVec<Quad>;
inline Quad length(const QuadVec& v) { return sqrtq(dot(v, v)); }

inline double size_of(const Point3& p) { return tessera::length(p - Point3{}); }
/// Some vector across `v`.
inline Vec3 across(const Vec3& v, Random& random) {
  Vec3 a;
  do a = tessera::cross(v, random.direction());
  while (tessera::length(a) < 0.1 * tessera::length(v));
  return normalize(a);
}

}  // namespace tessera::numerics
