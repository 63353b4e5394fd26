#include "renderer/scene/origins.h"

#include <unordered_map>

#include "proto/wire/node_numbers.h"

namespace tessera {

Origins::Origins(const v1::Scene& description, const NodeWays& ways) {
  std::unordered_map<const v1::Node*, uint32_t> numbers;
  for_each_node(description, [&](const v1::Node& node) {
    numbers.emplace(&node, static_cast<uint32_t>(numbers.size() + 1));
  });
  links_.reserve(ways.steps().size());
  for (const NodeWays::Step& step : ways.steps())
    links_.push_back({numbers.at(step.node), step.above});
}

void Origins::add_instance(const Shape* shape, uint32_t shape_number, uint32_t way) {
  places_.push_back({dynamic_cast<const CsgShape*>(shape), shape_number, way});
}

Origins::Chain Origins::of(uint32_t instance, uint32_t primitive) const {
  Chain chain{};
  size_t length = 0;
  const auto follow = [&](uint32_t way) {
    for (; way != kNoWay && length < chain.size(); way = links_[way].above)
      chain[length++] = links_[way].node;
  };
  const Place& place = places_[instance];
  if (place.csg) follow(solid_ways_[place.shape][place.csg->operand_of(primitive)]);
  follow(place.way);
  return chain;
}

}  // namespace tessera
