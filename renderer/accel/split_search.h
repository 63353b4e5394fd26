#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace tessera {

/// What the search for a node's split sees on one axis: the stretches of its objects.
struct AxisStretch {
  float low = 0, high = 0;                ///< the node
  float search_low = 0, search_high = 0;  ///< the split must be chosen in here
  std::vector<float> lows, highs;         ///< one a object, within the node

  /// g(b) = b L(b) + (1 - b) R(b), with b the place of `split` as a fraction of the node's width, L
  /// the objects that begin below it and R those that end above it. O(objects).
  double cost(float split) const;
};

/// Finds where to split a node: the place that minimises the product of the three axes' costs
/// (Hiller 2018). Deterministic; may be called by many threads.
class SplitSearch {
 public:
  virtual ~SplitSearch() = default;
  /// An axis whose search stretch is a single point keeps that point.
  virtual std::array<float, 3> find(const std::array<AxisStretch, 3>& axes) const = 0;
};

/// The factors of the product depend on an axis each and are never negative, so each is minimised
/// by itself; and each is linear between the ends of objects, so its minimum lies at an end. Exact
/// up to kExactObjects objects; of more, the best of kPlaces even places. O(n log n), no
/// randomness.
class SweepSearch final : public SplitSearch {
 public:
  static constexpr size_t kExactObjects = 2048;
  static constexpr size_t kPlaces = 1024;
  std::array<float, 3> find(const std::array<AxisStretch, 3>& axes) const override;
};

/// The study's own search: NLopt's MLSL with Sbplx as its local method, at most min(objects, 100)
/// evaluations, from a fixed seed. Loads the module that links NLopt; throws a usage Error where it
/// is not installed.
std::unique_ptr<const SplitSearch> make_nlopt_search();

// ---------------------------------------------------------------------------------- the module

/// Minimises a function of 1 to 3 variables inside a box. `x` starts at a guess and ends at the
/// best place found; false where nothing was found.
using NloptMinimize = bool (*)(unsigned dimensions, const double* low, const double* high,
                               double (*function)(const double* x, void* context), void* context,
                               int max_evaluations, double* x);
inline constexpr uint32_t kNloptModuleVersion = 1;
inline constexpr const char* kNloptModuleEntry = "tessera_nlopt_module";
/// Null where `version` is not the module's.
using NloptModuleEntry = NloptMinimize (*)(uint32_t version);

}  // namespace tessera
