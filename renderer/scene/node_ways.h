#pragma once

#include <cstdint>
#include <vector>

#include "proto/tessera/v1/scene.pb.h"

namespace tessera {

inline constexpr uint32_t kNoWay = 0xFFFFFFFF;

/// Which nodes lead to what is unfolded from a description: each way ends with a node, and goes on
/// from the way to what that node stands in.
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
