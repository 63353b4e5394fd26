#include "renderer/scene/scene_graph.h"

#include <fmt/format.h>

#include <algorithm>
#include <unordered_map>

#include "base/error.h"
#include "renderer/math/elementary.h"
#include "renderer/scene/read_shading.h"
#include "renderer/scene/read_transform.h"

namespace tessera {

namespace {

using Nodes = google::protobuf::RepeatedPtrField<v1::Node>;

/// What nodes inherit from above.
struct Inherited {
  Affine world_from_parent;
  uint32_t scope = 0;
  bool casts_shadow = true;
  int depth = 0;
  const std::string* name = nullptr;
  uint32_t way = kNoWay;
};

Vec3 column(const Affine& frame, size_t number) {
  return {frame.m[0][number], frame.m[1][number], frame.m[2][number]};
}

/// What turns a node to the viewer, whose frame is given in the node's (ISO/IEC 19775-1, 23.4.1):
/// +z to the viewer's place about `axis`, or where that is 0, all axes parallel to the viewer's
/// own, so that what is flat stays parallel to the picture wherever it is seen.
Affine billboard_turn(const Vec3& axis, const Affine& viewer) {
  const Vec3 to_viewer = column(viewer, 3);
  if (axis == Vec3{}) {
    if (!is_invertible(viewer)) return {};
    const Vec3 x = normalize(column(viewer, 0)), y = normalize(column(viewer, 1)),
               z = normalize(column(viewer, 2));
    Affine turn;
    for (size_t row = 0; row < 3; ++row) {
      const int r = static_cast<int>(row);
      turn.m[row] = {x[r], y[r], z[r], 0};
    }
    return turn;
  }
  const Vec3 a = normalize(axis);
  const Vec3 from = Vec3{0, 0, 1} - a * a.z, to = to_viewer - a * dot(a, to_viewer);
  if (!(length_squared(from) > 0) || !(length_squared(to) > 0)) return {};
  return rotation(a, portable::atan2(dot(a, cross(from, to)), dot(from, to)));
}

/// What nodes unfold to; beyond 2^53 about.
struct Unfolded {
  double nodes = 0, instances = 0;
  Unfolded& operator+=(const Unfolded& more) {
    nodes += more.nodes;
    instances += more.instances;
    return *this;
  }
};

class Walker {
 public:
  Walker(const v1::Scene& scene, double time, const Affine& viewer, bool keep_ways)
      : scene_(scene), time_(time), viewer_(viewer), keep_ways_(keep_ways) {
    graph_.scopes.emplace_back();
    for (const v1::Object& object : scene.objects()) {
      const Where where{.kind = "object", .name = object.name()};
      if (object.name().empty()) fail_value(where, "name", "empty", "a name");
      if (!objects_.try_emplace(object.name(), &object).second) {
        fail_value(where, "name", "used twice", "a name of its own");
      }
    }
  }

  SceneGraph run() {
    walk(nullptr, scene_.nodes(), {});
    graph_.objects_used = used_objects_.size();
    return std::move(graph_);
  }

 private:
  void walk(const Where* parent, const Nodes& nodes, Inherited inherited) {
    if (inherited.depth >= kMaxNodeDepth) {
      fail_value(*parent, "nesting", fmt::format("deeper than {} nodes", kMaxNodeDepth),
                 "a flatter scene");
    }
    inherited.scope = add_lights(parent, nodes, inherited);
    for (int i = 0; i < nodes.size(); ++i) {
      const v1::Node& node = nodes[i];
      if (node.hidden()) {
        ++graph_.hidden_nodes;
        continue;
      }
      const Where where{.parent = parent, .kind = "node", .name = node.name(), .index = i};
      visit(where, node, inherited);
    }
  }

  void visit(const Where& where, const v1::Node& node, Inherited inherited) {
    // Whoever names objects in objects makes much of little; small scenes are not counted twice.
    constexpr size_t kSmall = size_t{1} << 16;
    if (++visits_ == kSmall) check_unfolded();
    if (visits_ > kMaxNodeVisits) fail_nodes(where);
    if (!has_content(node)) return;
    inherited.world_from_parent = world_from_node(where, node, inherited);
    if (!is_invertible(inherited.world_from_parent)) {
      ++graph_.flat_nodes;
      return;
    }
    inherited.casts_shadow = inherited.casts_shadow && !node.casts_no_shadow();
    if (!node.name().empty()) inherited.name = &node.name();
    if (keep_ways_) inherited.way = graph_.ways.add(node, inherited.way);
    ++inherited.depth;
    if (node.has_shape()) add_instance(where, node.shape(), inherited);
    if (!node.instance_of().empty()) enter_object(where, node.instance_of(), inherited);
    if (!node.children().empty()) walk(&where, node.children(), inherited);
  }

  [[noreturn]] static void fail_nodes(const Where& where) {
    fail_value(where, "the scene", fmt::format("more than {} nodes once unfolded", kMaxNodeVisits),
               "fewer");
  }
  [[noreturn]] static void fail_instances(const Where& where) {
    fail_value(where, "the scene", fmt::format("more than {} instances", kMaxInstances), "fewer");
  }

  /// Refuses what would unfold too far before it does. Takes time in the length of the description.
  void check_unfolded() {
    Unfolded all;
    for (int i = 0; i < scene_.nodes_size(); ++i) {
      const v1::Node& node = scene_.nodes(i);
      all += unfolded(node, 0);
      const Where where{.kind = "node", .name = node.name(), .index = i};
      if (all.instances > kMaxInstances) fail_instances(where);
      if (all.nodes > kMaxNodeVisits) fail_nodes(where);
    }
  }

  Unfolded unfolded(const v1::Node& node, int depth) {
    Unfolded sum;
    if (node.hidden()) return sum;
    sum.nodes = 1;
    if (depth >= kMaxNodeDepth || !has_content(node) || is_flat(node)) return sum;
    if (node.has_shape()) sum.instances = 1;
    for (const v1::Node& child : node.children()) sum += unfolded(child, depth + 1);
    if (const auto found = objects_.find(node.instance_of()); found != objects_.end()) {
      const auto [at, is_new] = unfolded_.try_emplace(found->second);  // nothing while it is open
      if (is_new) {
        Unfolded object;
        for (const v1::Node& part : found->second->nodes()) object += unfolded(part, depth + 1);
        unfolded_[found->second] = object;
        sum += object;
      } else {
        sum += at->second;
      }
    }
    return sum;
  }

  /// Or wrong, which the way to it will tell.
  bool is_flat(const v1::Node& node) const {
    try {
      return !is_invertible(read_transform(Where{}, node.transform(), node.keys(), time_));
    } catch (const Error&) {
      return true;
    }
  }

  Affine world_from_node(const Where& where, const v1::Node& node,
                         const Inherited& inherited) const {
    const Affine frame =
        inherited.world_from_parent * read_transform(where, node.transform(), node.keys(), time_);
    if (!node.has_billboard_axis() || !is_invertible(frame)) return frame;
    return frame * billboard_turn(checked(where, "billboard_axis", node.billboard_axis()),
                                  inverse(frame) * viewer_);
  }

  static bool has_content(const v1::Node& node) {
    return node.has_shape() || !node.instance_of().empty() || !node.children().empty();
  }

  void enter_object(const Where& where, const std::string& name, const Inherited& inherited) {
    const auto found = objects_.find(name);
    if (found == objects_.end()) {
      std::vector<std::string> known;
      for (const v1::Object& object : scene_.objects()) known.push_back(object.name());
      throw scene_error(SourcePlace{where.str()},
                        fmt::format("instance_of names object '{}', which is not defined{}", name,
                                    suggestion(name, known)),
                        "");
    }
    const v1::Object* object = found->second;
    if (std::find(active_.begin(), active_.end(), object) != active_.end()) {
      fail_value(where, "instance_of", fmt::format("'{}', which it is itself a part of", name),
                 "an object without a cycle");
    }
    used_objects_.try_emplace(object, true);
    active_.push_back(object);
    const Where inside{.parent = &where, .kind = "object", .name = name};
    walk(&inside, object->nodes(), inherited);
    active_.pop_back();
  }

  void add_instance(const Where& where, const v1::Shape& shape, const Inherited& inherited) {
    if (graph_.instances.size() >= kMaxInstances) fail_instances(where);
    const auto [known, is_new] =
        shapes_.try_emplace(&shape, static_cast<uint32_t>(graph_.shapes.size()));
    if (is_new) {
      graph_.shapes.push_back({&shape, Where{&where, "shape", shape.name()}.str()});
    }
    graph_.instances.push_back({known->second, inherited.world_from_parent, inherited.scope,
                                inherited.casts_shadow, inherited.name, inherited.way});
  }

  /// Adds the lights that these siblings hold; returns the scope that they share.
  uint32_t add_lights(const Where* parent, const Nodes& nodes, const Inherited& inherited) {
    std::vector<uint32_t> scoped;
    for (int i = 0; i < nodes.size(); ++i) {
      const v1::Node& node = nodes[i];
      if (!node.has_light() || node.hidden()) continue;
      const Where node_where{.parent = parent, .kind = "node", .name = node.name(), .index = i};
      const Where where{.parent = &node_where, .kind = "light", .name = node.light().name()};
      const Affine frame = world_from_node(node_where, node, inherited);
      if (node.light().off() || !is_invertible(frame)) {
        ++graph_.lights_off;
        continue;
      }
      if (graph_.lights.size() >= kMaxLights) {
        fail_value(where, "the scene", fmt::format("more than {} lights", kMaxLights), "fewer");
      }
      const Light light = read_light(where, node.light(), frame);
      // Nothing tells where its light comes from.
      if (!is_finite(light.position - Point3{}) || !is_finite(light.direction)) {
        ++graph_.lights_off;
        continue;
      }
      const auto index = static_cast<uint32_t>(graph_.lights.size());
      graph_.lights.push_back(light);
      (node.light().scoped() ? scoped : graph_.global_lights).push_back(index);
    }
    if (scoped.empty()) return inherited.scope;
    std::vector<uint32_t> scope = graph_.scopes[inherited.scope];
    scope.insert(scope.end(), scoped.begin(), scoped.end());
    scoped_lights_ += scope.size();
    if (scoped_lights_ > kMaxScopedLights) {
      throw scene_error(
          fmt::format("more than {} scoped lights, each counted in every group that "
                      "it reaches; expected fewer",
                      kMaxScopedLights));
    }
    graph_.scopes.push_back(std::move(scope));
    return static_cast<uint32_t>(graph_.scopes.size() - 1);
  }

  const v1::Scene& scene_;
  const double time_;
  const Affine viewer_;
  const bool keep_ways_;
  SceneGraph graph_;
  size_t scoped_lights_ = 0;
  std::unordered_map<std::string_view, const v1::Object*> objects_;
  std::unordered_map<const v1::Shape*, uint32_t> shapes_;
  std::unordered_map<const v1::Object*, bool> used_objects_;
  std::vector<const v1::Object*> active_;
  size_t visits_ = 0;
  std::unordered_map<const v1::Object*, Unfolded> unfolded_;
};

}  // namespace

SceneGraph unfold_graph(const v1::Scene& scene, double time, const Affine& viewer, bool keep_ways) {
  return Walker(scene, time, viewer, keep_ways).run();
}

}  // namespace tessera
