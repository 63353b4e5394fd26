#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "proto/tessera/v1/scene.pb.h"
#include "renderer/film/aov.h"
#include "renderer/scene/node_ways.h"
#include "renderer/shapes/csg_shape.h"

namespace tessera {

/// The nodes of the description that instances stand in, by their numbers.
class Origins {
 public:
  /// The innermost first; 0 behind the outermost.
  using Chain = std::array<uint32_t, kOriginDepth>;

  Origins(const v1::Scene& description, const NodeWays& ways);
  /// Of a set operation the ways to its solids, by operand; else none.
  void add_shape(std::vector<uint32_t> solid_ways) { solid_ways_.push_back(std::move(solid_ways)); }
  /// `shape_number` counts the shapes as they were added.
  void add_instance(const Shape* shape, uint32_t shape_number, uint32_t way);

  /// The nodes around what a hit met, the outermost first.
  Chain of(uint32_t instance, uint32_t primitive) const;

 private:
  struct Link {
    uint32_t node = 0;  ///< number
    uint32_t above = kNoWay;
  };
  struct Place {
    const CsgShape* csg = nullptr;  ///< null for another shape
    uint32_t shape = 0;
    uint32_t way = kNoWay;
  };

  std::vector<Link> links_;
  std::vector<std::vector<uint32_t>> solid_ways_;  ///< by shape
  std::vector<Place> places_;                      ///< by instance
};

}  // namespace tessera
