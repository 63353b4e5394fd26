#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace tessera {

/// One line of `tessera bench precision`: one way to test a shape of about unit size, at a
/// distance.
struct PrecisionBenchRow {
  std::string shape;   ///< triangle, sphere, torus
  std::string method;  ///< as "float-moller-trumbore"; "robust" is what Tessera does
  double distance = 0;
  double nanoseconds = 0;  ///< a test; one thread, the least of the rounds
  double rms_error = 0;    ///< of the distance to the hit, where oracle and method both hit
  double max_error = 0;    ///< the same; in units of the shape's size
  double wrong = 0;        ///< hits or misses that the oracle contradicts, a million rays
  double leaks = 0;        ///< triangle: rays through edges and vertices of a closed mesh that miss
                           ///< it, a million rays
  double self_hits = 0;    ///< rays that leave the hit and meet the shape at once, a million rays
};

struct PrecisionBenchOptions {
  int rays = 100'000;  ///< a shape, distance and method
  int rounds = 5;
  uint64_t seed = 1;
};

/// Each method on the same rays, against an oracle of twice the precision of double.
std::vector<PrecisionBenchRow> bench_precision(const PrecisionBenchOptions& options);

/// Both kinds of text that `tessera bench precision` writes.
std::string precision_table(const std::vector<PrecisionBenchRow>& rows);
std::string precision_json(const std::vector<PrecisionBenchRow>& rows);

}  // namespace tessera
