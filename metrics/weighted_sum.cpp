#include "metrics/weighted_sum.h"

#include "base/targets.h"

// This file is compiled once for each instruction set.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "metrics/weighted_sum.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <typename T>
void sum(T* out, size_t count, std::span<const T> weights, std::span<const T* const> rows) {
  const hn::ScalableTag<T> tag;
  const size_t lanes = hn::Lanes(tag);
  size_t x = 0;
  for (; x + 4 * lanes <= count; x += 4 * lanes) {
    auto a = hn::Zero(tag), b = a, c = a, d = a;
    for (size_t k = 0; k < weights.size(); ++k) {
      const auto weight = hn::Set(tag, weights[k]);
      const T* const in = rows[k] + x;
      a = hn::Add(a, hn::Mul(weight, hn::LoadU(tag, in)));
      b = hn::Add(b, hn::Mul(weight, hn::LoadU(tag, in + lanes)));
      c = hn::Add(c, hn::Mul(weight, hn::LoadU(tag, in + 2 * lanes)));
      d = hn::Add(d, hn::Mul(weight, hn::LoadU(tag, in + 3 * lanes)));
    }
    hn::StoreU(a, tag, out + x);
    hn::StoreU(b, tag, out + x + lanes);
    hn::StoreU(c, tag, out + x + 2 * lanes);
    hn::StoreU(d, tag, out + x + 3 * lanes);
  }
  for (; x < count; ++x) {
    out[x] = 0;
    for (size_t k = 0; k < weights.size(); ++k) out[x] += weights[k] * rows[k][x];
  }
}

void sum_floats(float* out, size_t count, std::span<const float> weights,
                std::span<const float* const> rows) {
  sum(out, count, weights, rows);
}

void sum_doubles(double* out, size_t count, std::span<const double> weights,
                 std::span<const double* const> rows) {
  sum(out, count, weights, rows);
}

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tessera {
void weighted_sum(float* out, size_t count, std::span<const float> weights,
                  std::span<const float* const> rows) {
  static const auto sum = best_code_of_machine(TESSERA_EACH_TARGET(sum_floats));
  sum(out, count, weights, rows);
}

void weighted_sum(double* out, size_t count, std::span<const double> weights,
                  std::span<const double* const> rows) {
  static const auto sum = best_code_of_machine(TESSERA_EACH_TARGET(sum_doubles));
  sum(out, count, weights, rows);
}

}  // namespace tessera
#endif  // HWY_ONCE
