#pragma once

#include <cstddef>
#include <cstdint>
#include <random>

namespace tessera {

/// Numbers in [0, 1) by a generator whose bits are those of the standard everywhere.
class UniformNumbers {
 public:
  explicit UniformNumbers(uint64_t seed) : engine_(seed) {}
  double operator()() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * (*this)(); }
  size_t below(size_t count) { return engine_() % count; }

 private:
  std::mt19937_64 engine_;
};

}  // namespace tessera
