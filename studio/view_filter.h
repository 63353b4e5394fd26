#pragma once

#include <compare>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "proto/tessera/v1/scene.pb.h"

namespace tessera {

class SourceMap;

/// An entity of a text, as pages call it.
struct EntityRef {
  std::string file, entity;
  friend auto operator<=>(const EntityRef&, const EntityRef&) = default;
};

/// What a view leaves out of its scene, whose text stays as it is. A value.
struct ViewFilter {
  std::vector<EntityRef> hidden{};
  /// If any: of what has a shape, nothing else is seen. Lights go on shining.
  std::vector<EntityRef> solo{};
  bool empty() const { return hidden.empty() && solo.empty(); }
  friend auto operator<=>(const ViewFilter&, const ViewFilter&) = default;
};

/// The numbers of the nodes to be hidden for it, in order.
std::vector<uint32_t> hidden_nodes(const ViewFilter& filter, SourceMap& map);

/// Hides the nodes of those numbers, with all below them.
void hide_nodes(const std::vector<uint32_t>& numbers, v1::Scene& scene);

/// The entities that made nodes of the scene, each with centre and size of what they are, where
/// that ends somewhere, and how many things are made by its text itself, 0 where that is not known;
/// of those whose axes are not the world's the rows of the matrix that leads there: {file, version,
/// list: [[file, entity, [x, y, z] or null, the same, number, [12 numbers]], ...]}.
nlohmann::json centers_json(SourceMap& map);

}  // namespace tessera
