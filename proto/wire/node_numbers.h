#pragma once

#include <type_traits>

#include "proto/tessera/v1/scene.pb.h"

namespace tessera {

/// Calls use(node) for the node and all below it in the order of their numbers.
template <typename Node, typename Use>
void for_each_node_of(Node& node, const Use& use) {
  use(node);
  if constexpr (std::is_const_v<Node>) {
    if (node.shape().has_csg())
      for (const v1::Node& operand : node.shape().csg().operands()) for_each_node_of(operand, use);
    for (const v1::Node& child : node.children()) for_each_node_of(child, use);
  } else {
    if (node.shape().has_csg())
      for (v1::Node& operand : *node.mutable_shape()->mutable_csg()->mutable_operands())
        for_each_node_of(operand, use);
    for (v1::Node& child : *node.mutable_children()) for_each_node_of(child, use);
  }
}

/// Calls use(node) for every node of a scene in the order of their numbers, which count from 1:
/// those of the scene, then those of its objects; each before its operands, and these before its
/// children. So text may move, and notes be added to it, and every node keeps its number.
template <typename Scene, typename Use>
void for_each_node(Scene& scene, const Use& use) {
  if constexpr (std::is_const_v<Scene>) {
    for (const v1::Node& node : scene.nodes()) for_each_node_of(node, use);
    for (const v1::Object& object : scene.objects())
      for (const v1::Node& node : object.nodes()) for_each_node_of(node, use);
  } else {
    for (v1::Node& node : *scene.mutable_nodes()) for_each_node_of(node, use);
    for (v1::Object& object : *scene.mutable_objects())
      for (v1::Node& node : *object.mutable_nodes()) for_each_node_of(node, use);
  }
}

}  // namespace tessera
