#include "studio/view_filter.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "proto/wire/node_numbers.h"
#include "studio/scene_extent.h"
#include "studio/source_map.h"

namespace tessera {
namespace {

struct MadeNodes {
  /// Those that a call, a turn of a loop or an include made are its own, too.
  std::vector<uint32_t> all;
  std::vector<uint32_t> itself;  ///< those that its text describes
};
using NodesOfEntities = std::map<EntityRef, MadeNodes>;

/// Which nodes each entity made.
NodesOfEntities nodes_of_entities(SourceMap& map) {
  NodesOfEntities nodes;
  uint32_t number = 0;
  for_each_node(map.reading().scene->loaded.scene, [&](const v1::Node&) {
    ScenePart part;
    part.nodes[0] = ++number;
    const SourceChain chain = map.chain(part);
    for (size_t i = chain.at; i < chain.links.size(); ++i) {
      const SourceLink& link = chain.links[i];
      if (link.entity.empty()) continue;
      MadeNodes& made = nodes[{link.file, link.entity}];
      made.all.push_back(number);
      if (i == chain.at) made.itself.push_back(number);
    }
  });
  return nodes;
}

/// Finds what is left out where something is seen alone.
class SoloFinder {
 public:
  SoloFinder(const v1::Scene& scene, const std::set<uint32_t>& solo) : scene_(scene), solo_(solo) {
    for_each_node(scene, [this](const v1::Node& node) { numbers_[&node] = ++count_; });
    for (const v1::Object& object : scene.objects()) objects_[object.name()] = &object;
  }

  std::vector<uint32_t> hidden() {
    for (const v1::Node& node : scene_.nodes()) keep(node, false, 0);
    std::vector<uint32_t> numbers;
    const auto hide = [&](const auto& nodes) {
      for (const v1::Node& node : nodes) collect(node, numbers);
    };
    hide(scene_.nodes());
    for (const v1::Object& object : scene_.objects()) hide(object.nodes());
    std::sort(numbers.begin(), numbers.end());
    return numbers;
  }

 private:
  static constexpr int kMostDepth = 64;
  static constexpr size_t kMostVisits = 1 << 20;

  /// Whether any of the node is to be seen; `all`: it stands in something that is.
  bool keep(const v1::Node& node, bool all, int depth) {
    if (depth > kMostDepth || ++visits_ > kMostVisits) return true;
    all = all || solo_.contains(numbers_.at(&node));
    bool is_kept = all || node.has_light();
    const auto visit = [&](const auto& nodes) {
      for (const v1::Node& below : nodes) is_kept = keep(below, all, depth + 1) || is_kept;
    };
    visit(node.children());
    if (node.shape().has_csg()) visit(node.shape().csg().operands());
    if (const auto object = objects_.find(node.instance_of()); object != objects_.end())
      visit(object->second->nodes());
    if (is_kept) kept_.insert(&node);
    return is_kept;
  }

  /// The outermost nodes that are hidden whole.
  void collect(const v1::Node& node, std::vector<uint32_t>& numbers) const {
    if (!kept_.contains(&node)) {
      numbers.push_back(numbers_.at(&node));
      return;
    }
    for (const v1::Node& child : node.children()) collect(child, numbers);
    if (!node.shape().has_csg()) return;
    for (const v1::Node& operand : node.shape().csg().operands()) collect(operand, numbers);
  }

  const v1::Scene& scene_;
  const std::set<uint32_t>& solo_;
  std::unordered_map<const v1::Node*, uint32_t> numbers_;
  std::unordered_map<std::string, const v1::Object*> objects_;
  std::set<const v1::Node*> kept_;
  uint32_t count_ = 0;
  size_t visits_ = 0;
};

}  // namespace

std::vector<uint32_t> hidden_nodes(const ViewFilter& filter, SourceMap& map) {
  if (filter.empty()) return {};
  const NodesOfEntities nodes = nodes_of_entities(map);
  const auto numbers_of = [&nodes](const std::vector<EntityRef>& entities) {
    std::set<uint32_t> numbers;
    for (const EntityRef& entity : entities) {
      const auto found = nodes.find(entity);
      if (found != nodes.end()) numbers.insert(found->second.all.begin(), found->second.all.end());
    }
    return numbers;
  };
  std::set<uint32_t> hidden = numbers_of(filter.hidden);
  // What is not in the text any more leaves nothing alone.
  const std::set<uint32_t> solo = numbers_of(filter.solo);
  if (!solo.empty()) {
    const auto others = SoloFinder(map.reading().scene->loaded.scene, solo).hidden();
    hidden.insert(others.begin(), others.end());
  }
  return {hidden.begin(), hidden.end()};
}

void hide_nodes(const std::vector<uint32_t>& numbers, v1::Scene& scene) {
  if (numbers.empty()) return;
  uint32_t number = 0;
  auto next = numbers.begin();
  for_each_node(scene, [&](v1::Node& node) {
    if (next == numbers.end() || *next != ++number) return;
    node.set_hidden(true);
    ++next;
  });
}

nlohmann::json centers_json(SourceMap& map) {
  const std::vector<NodeExtent> extents = node_extents(map.reading().scene->loaded);
  nlohmann::json list = nlohmann::json::array();
  for (const auto& [entity, nodes] : nodes_of_entities(map)) {
    Bounds3 all;
    for (const uint32_t node : nodes.all) all.extend(extents[node].bounds);
    size_t times = 0;
    for (const uint32_t node : nodes.itself) times += extents[node].times;
    nlohmann::json center, size;
    if (!all.empty()) {
      center = {all.center().x, all.center().y, all.center().z};
      size = {all.diagonal().x, all.diagonal().y, all.diagonal().z};
    }
    list.push_back({entity.file, entity.entity, std::move(center), std::move(size), times});
    const Affine axes = nodes.itself.empty() ? Affine{} : extents[nodes.itself[0]].world;
    if (axes == Affine{}) continue;
    nlohmann::json& rows = list.back().emplace_back(nlohmann::json::array());
    for (const auto& row : axes.m)
      for (const double each : row) rows.push_back(each);
  }
  return {
      {"file", map.reading().file}, {"version", map.reading().version}, {"list", std::move(list)}};
}

}  // namespace tessera
