#pragma once

#include <string>
#include <vector>

#include "proto/tessera/v1/scene.pb.h"
#include "renderer/math/transform.h"
#include "renderer/scene/check.h"
#include "renderer/scene/node_ways.h"
#include "renderer/shapes/csg_gates.h"

namespace tessera {

/// A CSG shape with its nodes unfolded: its solids with their places, and how they are combined.
struct CsgPlan {
  struct Step {
    const v1::Shape* solid = nullptr;  ///< null: an operator
    std::string material{};            ///< of a solid that names none; empty: the default
    Affine csg_from_solid{};           ///< invertible
    std::string path;                  ///< for errors
    CsgOperation operation = CsgOperation::join;
    std::vector<uint32_t> operands;  ///< earlier steps
    uint32_t way = kNoWay;           ///< to a solid, from the shape; kNoWay: they are not kept
  };
  /// Operands come before what they make; the last step is the whole. Empty: so is the whole.
  std::vector<Step> steps;

  /// Of the solids that the whole is made of, in the order of CsgShape::operand_of(), their ways.
  std::vector<uint32_t> solid_ways() const;
};

/// A node's solid is the union of those below it; what is hidden or flat is not there. Throws a
/// scene error that begins with `where` for cycles, unknown objects, and what is too deep or too
/// much.
/// Ways to solids are added to `ways`, where it is given.
CsgPlan plan_csg(const Where& where, const v1::Shape& csg, const v1::Scene& scene, double time,
                 NodeWays* ways = nullptr);

}  // namespace tessera
