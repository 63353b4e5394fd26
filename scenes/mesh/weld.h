#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace tessera {

/// For each point (x y z each) the first one in their order that no earlier one of these stands
/// for and that lies within `distance` > 0 of it: itself, if there is none. Not transitive.
std::vector<uint32_t> weld(std::span<const float> points, double distance);

}  // namespace tessera
