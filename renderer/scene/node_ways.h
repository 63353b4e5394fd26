#pragma once

#include <cstdint>
#include <vector>

#include "proto/tessera/v1/scene.pb.h"

namespace tessera {

inline constexpr uint32_t kNoWay = 0xFFFFFFFF;

/// Paths through the nodes of a description, as links upwards: each names a node and the link to
/// what that node stands in; kNoWay: it stands in the scene itself.
class NodeWays {
 public:
  struct Step {
    const v1::Node* node = nullptr;
    uint32_t above = kNoWay;
  };

  uint32_t add(const v1::Node& node, uint32_t above) {
    steps_.push_back({&node, above});
    return static_cast<uint32_t>(steps_.size() - 1);
  }
  const std::vector<Step>& steps() const { return steps_; }

 private:
  std::vector<Step> steps_;
};

}  // namespace tessera
