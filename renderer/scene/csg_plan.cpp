#include "renderer/scene/csg_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "base/error.h"
#include "renderer/scene/read_transform.h"

namespace tessera {

namespace {

constexpr int kMaxDepth = 200;
constexpr size_t kMaxSteps = 1'000'000;

/// The number of a step; nothing for an empty solid.
using Part = std::optional<uint32_t>;
using Nodes = google::protobuf::RepeatedPtrField<v1::Node>;

class Planner {
 public:
  Planner(const v1::Scene& scene, double time, NodeWays* ways)
      : scene_(scene), time_(time), ways_(ways) {}

  Part combine(const Where& where, const v1::Shape& shape, const Affine& to_whole) {
    const v1::Csg& csg = shape.csg();
    std::string around = material_;
    if (!shape.materials().empty()) material_ = shape.materials(0);
    if (++depth_ > kMaxDepth) {
      fail_value(where, "nesting", fmt::format("deeper than {} levels", kMaxDepth),
                 "a flatter combination, without a cycle");
    }
    CsgPlan::Step step;
    step.operation = csg.operation() == v1::Csg::INTERSECTION ? CsgOperation::intersect
                     : csg.operation() == v1::Csg::DIFFERENCE ? CsgOperation::subtract
                                                              : CsgOperation::join;
    bool is_nothing = csg.operands().empty();
    for (int i = 0; i < csg.operands_size(); ++i) {
      const Part part = read_node(where, csg.operands(i), i, to_whole);
      const bool needed = step.operation == CsgOperation::intersect ||
                          (step.operation == CsgOperation::subtract && i == 0);
      if (part) step.operands.push_back(*part);
      is_nothing |= needed && !part;
    }
    --depth_;
    material_ = std::move(around);
    if (is_nothing || step.operands.empty()) return std::nullopt;
    return step.operands.size() == 1 ? step.operands.front() : add(where, std::move(step));
  }

  CsgPlan take() { return std::move(plan_); }

 private:
  uint32_t add(const Where& where, CsgPlan::Step step) {
    if (plan_.steps.size() >= kMaxSteps) {
      fail_value(where, "the combination", fmt::format("of more than {} parts", kMaxSteps),
                 "fewer");
    }
    step.path = where.str();
    plan_.steps.push_back(std::move(step));
    return static_cast<uint32_t>(plan_.steps.size() - 1);
  }

  Part read_node(const Where& parent, const v1::Node& node, int index, const Affine& parent_place) {
    if (node.hidden()) return std::nullopt;
    const Where where{.parent = &parent, .kind = "operand", .name = node.name(), .index = index};
    const Affine place = parent_place * read_transform(where, node.transform(), node.keys(), time_);
    if (!is_invertible(place)) return std::nullopt;
    const uint32_t way_before = way_;
    if (ways_) way_ = ways_->add(node, way_);
    std::vector<uint32_t> below;
    const auto keep = [&](const Part& part) {
      if (part) below.push_back(*part);
    };
    if (node.has_shape()) keep(read_shape(where, node.shape(), place));
    if (!node.instance_of().empty()) {
      join(where, object(where, node.instance_of()).nodes(), place, below);
    }
    join(where, node.children(), place, below);
    way_ = way_before;
    if (below.empty()) return std::nullopt;
    if (below.size() == 1) return below.front();
    CsgPlan::Step step;
    step.operands = std::move(below);
    return add(where, std::move(step));
  }

  void join(const Where& where, const Nodes& nodes, const Affine& place,
            std::vector<uint32_t>& below) {
    if (++depth_ > kMaxDepth) {
      fail_value(where, "nesting", fmt::format("deeper than {} levels", kMaxDepth),
                 "a flatter combination, without a cycle");
    }
    for (int i = 0; i < nodes.size(); ++i) {
      if (const Part part = read_node(where, nodes[i], i, place)) below.push_back(*part);
    }
    --depth_;
  }

  Part read_shape(const Where& where, const v1::Shape& shape, const Affine& place) {
    if (shape.has_csg()) return combine(where, shape, place);
    CsgPlan::Step step;
    step.solid = &shape;
    step.material = material_;
    step.csg_from_solid = place;
    step.way = way_;
    return add(where, std::move(step));
  }

  const v1::Object& object(const Where& where, const std::string& name) const {
    std::vector<std::string> known;
    for (const v1::Object& candidate : scene_.objects()) {
      if (candidate.name() == name) return candidate;
      known.push_back(candidate.name());
    }
    fail_value(where, "instance_of", fmt::format("'{}'", name),
               "an object of the scene" + suggestion(name, known));
  }

  const v1::Scene& scene_;
  double time_;
  NodeWays* const ways_;
  uint32_t way_ = kNoWay;
  std::string material_;  ///< the first of the nearest combination around that names one
  CsgPlan plan_;
  int depth_ = 0;
};

}  // namespace

std::vector<uint32_t> CsgPlan::solid_ways() const {
  std::vector<uint32_t> ways;
  if (steps.empty()) return ways;
  std::vector<uint32_t> open{static_cast<uint32_t>(steps.size() - 1)};
  while (!open.empty()) {
    const Step& step = steps[open.back()];
    open.pop_back();
    if (step.solid) ways.push_back(step.way);
    open.insert(open.end(), step.operands.rbegin(), step.operands.rend());
  }
  return ways;
}

CsgPlan plan_csg(const Where& where, const v1::Shape& csg, const v1::Scene& scene, double time,
                 NodeWays* ways) {
  Planner planner(scene, time, ways);
  const Part whole = planner.combine(where, csg, Affine{});
  CsgPlan plan = planner.take();
  if (!whole) return {};
  // What an empty operand left behind is not part of the whole.
  plan.steps.resize(*whole + 1);
  return plan;
}

}  // namespace tessera
