#pragma once

#include "proto/tessera/v1/scene.pb.h"
#include "renderer/math/transform.h"

namespace tessera {

/// The product of the steps, for importers that have to know where things stand. Steps that are no
/// transform, which SceneBuilder refuses later, count for nothing.
Affine to_affine(const v1::Transform& transform);

}  // namespace tessera
