#include "renderer/shapes/csg_gates.h"

#include <algorithm>

#include "base/error.h"

namespace tessera {
namespace {

Bounds3 overlap(const Bounds3& a, const Bounds3& b) {
  Bounds3 box;
  for (int axis = 0; axis < 3; ++axis) {
    box.min[axis] = std::max(a.min[axis], b.min[axis]);
    box.max[axis] = std::min(a.max[axis], b.max[axis]);
  }
  return box;
}

}  // namespace

CsgTree::Node CsgTree::add(const std::shared_ptr<const Shape>& shape,
                           const Transform& csg_from_solid, uint32_t first_material) {
  auto solid = std::dynamic_pointer_cast<const Solid>(shape);
  if (!solid)
    throw scene_error(
        "a CSG operand is a surface without an inside; expected a closed mesh or a solid");
  if (!solid->closed())
    throw scene_error(
        "a CSG operand has open parts; expected a cylinder or cone with side and caps");
  entries_.push_back({true, CsgOperation::join, static_cast<uint32_t>(leaves_.size()), 0});
  leaves_.push_back({std::move(solid), csg_from_solid, first_material});
  return static_cast<Node>(entries_.size() - 1);
}

CsgTree::Node CsgTree::combine(CsgOperation operation, std::span<const Node> operands) {
  if (operands.empty()) throw scene_error("a CSG operator has no operands; expected at least one");
  const auto begin = static_cast<uint32_t>(operands_.size());
  for (const Node node : operands) {
    if (node >= entries_.size() || entries_[node].used)
      throw scene_error("a CSG operand is missing or used twice; expected each node once");
    entries_[node].used = true;
    operands_.push_back(node);
  }
  entries_.push_back({false, operation, begin, static_cast<uint32_t>(operands_.size())});
  return static_cast<Node>(entries_.size() - 1);
}

CsgGates::CsgGates(const CsgTree& tree, CsgTree::Node root) {
  if (root >= tree.entries_.size())
    throw scene_error("a CSG tree has no root; expected at least one solid");
  emit(tree, root);
  settle();
}

void CsgGates::emit(const CsgTree& tree, CsgTree::Node root) {
  // Depth-first with an explicit stack: scenes may nest deeper than the machine's stack.
  struct Step {
    CsgTree::Node node;
    bool complement;
    uint32_t parent;
  };
  std::vector<Step> stack{{root, false, kNone}};
  uint64_t primitives = 0;
  while (!stack.empty()) {
    const Step step = stack.back();
    stack.pop_back();
    const CsgTree::Entry& entry = tree.entries_[step.node];
    const auto number = static_cast<uint32_t>(gates_.size());
    if (entry.is_leaf) {
      const CsgTree::Leaf& from = tree.leaves_[entry.begin];
      Gate& gate = gates_.emplace_back();
      gate.bounds = from.csg_from_solid.bounds(from.solid->bounds());
      gate.parent = step.parent;
      gate.need = 1;
      gate.initial = step.complement ? 1 : 0;
      gate.leaf = static_cast<uint32_t>(leaves_.size());
      leaves_.push_back({from.solid, dynamic_cast<const ConvexSolid*>(from.solid.get()),
                         from.csg_from_solid, !(from.csg_from_solid.matrix() == Affine{}),
                         step.complement, number, from.first_material,
                         static_cast<uint32_t>(primitives)});
      primitives += from.solid->primitive_count();
      continue;
    }
    uint32_t gate = step.parent;
    if (entry.end - entry.begin > 1) {
      const Kind kind =
          (entry.operation == CsgOperation::join) != step.complement ? Kind::any : Kind::all;
      if (step.parent == kNone || gates_[step.parent].kind != kind) {
        gate = number;
        gates_.push_back(
            {kind, kind == Kind::any ? Bounds3{} : Bounds3::everywhere(), step.parent});
      }
    }
    for (uint32_t i = entry.end; i-- > entry.begin;) {
      const bool subtracted = entry.operation == CsgOperation::subtract && i != entry.begin;
      stack.push_back({tree.operands_[i], step.complement != subtracted, gate});
    }
  }
  if (primitives > kNone)
    throw scene_error("a CSG tree has more than 2^32 primitives; expected fewer");
  primitive_count_ = static_cast<uint32_t>(primitives);
}

void CsgGates::settle() {
  // Parents come before their inputs, so that this runs from the leaves up.
  for (auto i = static_cast<uint32_t>(gates_.size()); i-- > 0;) {
    Gate& gate = gates_[i];
    gate.end = std::max(gate.end, i + 1);
    if (gate.kind == Kind::any) gate.need = 1;
    if (gate.parent == kNone) continue;
    Gate& parent = gates_[gate.parent];
    parent.end = std::max(parent.end, gate.end);
    ++parent.need;
    if (holds(gate, gate.initial)) ++parent.initial;
    const bool complement = gate.leaf != kNone && leaves_[gate.leaf].complement;
    const Bounds3& bounds = complement ? Bounds3::everywhere() : gate.bounds;
    if (parent.kind == Kind::any)
      parent.bounds.extend(bounds);
    else
      parent.bounds = overlap(parent.bounds, bounds);
  }
  for (Gate& gate : gates_) gate.as_whole = gate.bounds == bounds();
}

}  // namespace tessera
