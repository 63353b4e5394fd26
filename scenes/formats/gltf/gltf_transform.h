#pragma once

#include <vector>

#include "renderer/math/transform.h"
#include "scenes/formats/gltf/gltf_value.h"

namespace tessera {

/// The turn by a quaternion x y z w, made a unit one. Warns at `place` of one whose length differs
/// from 1 by more than `rounding`; one of length 0 turns nothing.
Affine gltf_rotation(const std::vector<double>& q, const GltfValue& place, double rounding);
/// The matrix of 16 numbers, column by column, with 0 0 0 1 as its last row: a projection cannot be
/// kept, and other programs do not read that row either. Warns at `place` of a row that differs by
/// more than products of single precision are rounded.
Affine gltf_matrix(const std::vector<double>& columns, const GltfValue& place);
/// The matrix of a node, or its translation * rotation * scale.
Affine gltf_transform(const GltfValue& node);

}  // namespace tessera
