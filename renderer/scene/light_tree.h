#pragma once

#include <cstdint>
#include <vector>

#include "renderer/math/bounds.h"
#include "renderer/math/vec.h"

namespace tessera {

/// Picks one of many lights by what it can bring to a point: power over the square of the distance,
/// by the cosine at the point, from the root of a binary tree downwards (Conty Estevez and Kulla
/// 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting", without the splitting).
/// Immutable once built; thread-safe.
class LightTree {
 public:
  struct Light {
    Bounds3 bounds;
    double power = 0;  ///< > 0
  };
  struct Pick {
    uint32_t index = 0;
    double probability = 1;
  };

  LightTree() = default;
  explicit LightTree(const std::vector<Light>& lights);

  /// The light that `u`, uniform in [0, 1), chooses for the point `p` of normal `n`. Every light
  /// has a probability above 0, whatever side it is on. Not of an empty tree.
  Pick pick(const Point3& p, const Vec3& n, double u) const;
  /// The probability with which pick() chooses light `index`.
  double probability(const Point3& p, const Vec3& n, uint32_t index) const;

 private:
  struct Node {
    Point3 center;
    double radius = 0;  ///< of a ball about all its lights
    double power = 0;
    uint32_t light = 0;  ///< of a leaf
    uint32_t right = 0;  ///< the second child; 0: a leaf. The first child is the next node.
    uint32_t parent = 0;
  };
  uint32_t build(const std::vector<Light>& lights, std::vector<uint32_t>& order, size_t from,
                 size_t to, uint32_t parent);
  /// The share of the first child of `node`.
  double share_of_first(const Node& node, uint32_t index, const Point3& p, const Vec3& n) const;

  std::vector<Node> nodes_;
  std::vector<uint32_t> leaves_;  ///< the node of each light
};

}  // namespace tessera
