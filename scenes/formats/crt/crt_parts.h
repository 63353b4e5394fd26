#pragma once

#include <vector>

#include "scenes/formats/crt/crt_value.h"

namespace tessera {

using CrtParts = std::vector<std::vector<const CrtEntity*>>;

/// The operands of a union in groups whose boxes keep clear of each other, in the order of their
/// first operands: the union of each group, side by side, is that of all. What has no box that is
/// known here, as a plane, belongs to everything.
CrtParts parts_apart(const std::vector<const CrtEntity*>& operands);

}  // namespace tessera
