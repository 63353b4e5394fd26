#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "renderer/math/transform.h"
#include "renderer/shapes/solid.h"

namespace tessera {

enum class CsgOperation { join, intersect, subtract };

/// Describes a combination of solids: leaves and operators over earlier nodes, each of them
/// used once. Depth and width are bounded by memory alone.
class CsgTree {
 public:
  using Node = uint32_t;

  /// A solid placed in the CSG's frame. Its materials are numbers `first_material` and up of the
  /// whole. Throws Error for a shape that has no inside or is open.
  Node add(const std::shared_ptr<const Shape>& shape, const Transform& csg_from_solid = {},
           uint32_t first_material = 0);
  /// Subtraction takes all other operands from the first. Throws Error for no operands, and for a
  /// node that is not there or used already.
  Node combine(CsgOperation operation, std::span<const Node> operands);

 private:
  friend class CsgGates;
  struct Leaf {
    std::shared_ptr<const Solid> solid;
    Transform csg_from_solid;
    uint32_t first_material;
  };
  struct Entry {
    bool is_leaf;
    CsgOperation operation;
    uint32_t begin, end;  ///< operands_; for a leaf, `begin` is its place in leaves_
    bool used = false;
  };
  std::vector<Entry> entries_;
  std::vector<Node> operands_;
  std::vector<Leaf> leaves_;
};

/// The tree in a normal form that regrouping does not change: subtraction becomes intersection with
/// a complement, complements are pushed down to the leaves (De Morgan), and operators of the same
/// kind are merged. What is left are gates that count how many of their inputs hold.
class CsgGates {
 public:
  static constexpr uint32_t kNone = ~0u;
  enum class Kind : uint8_t { all, any, leaf };
  struct Gate {
    Kind kind = Kind::leaf;
    Bounds3 bounds;           ///< outside of it the gate holds or not as at infinity
    uint32_t parent = kNone;  ///< gate 0 is the root
    uint32_t end = 0;         ///< one past the gates below this one, which follow it
    uint32_t need = 0;        ///< inputs that must hold
    uint32_t initial = 0;     ///< inputs that hold outside of all solids
    uint32_t leaf = kNone;
    bool as_whole = false;  ///< it has the bounds of the whole: the first operand of a difference
  };
  struct Leaf {
    std::shared_ptr<const Solid> solid;
    const ConvexSolid* convex = nullptr;  ///< the solid, if it is
    Transform csg_from_solid;
    bool moved = false;       ///< whether the transform does anything
    bool complement = false;  ///< what counts is being outside
    uint32_t gate = 0;
    uint32_t first_material = 0;
    uint32_t first_primitive = 0;
  };

  CsgGates(const CsgTree& tree, CsgTree::Node root);

  const std::vector<Gate>& gates() const { return gates_; }
  const std::vector<Leaf>& leaves() const { return leaves_; }
  uint32_t primitive_count() const { return primitive_count_; }
  /// Of the whole; endless where it is.
  const Bounds3& bounds() const { return gates_[0].bounds; }
  /// Whether the gate holds with `count` inputs holding.
  static bool holds(const Gate& gate, uint32_t count) { return count >= gate.need; }

 private:
  void emit(const CsgTree& tree, CsgTree::Node root);
  void settle();

  std::vector<Gate> gates_;  ///< in preorder
  std::vector<Leaf> leaves_;
  uint32_t primitive_count_ = 0;
};

}  // namespace tessera
