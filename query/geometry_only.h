#pragma once

#include "proto/tessera/v1/farm.pb.h"
#include "proto/tessera/v1/scene.pb.h"

namespace tessera {

/// The scene without whatever light does in it: no lights, background, fog or textures, every
/// material an opaque one of two sides, of the same name. Every surface stops every ray.
v1::Scene geometry_only(const v1::Scene& scene);
/// A frame of the same size, camera, time and accelerator.
v1::FrameSettings geometry_only(const v1::FrameSettings& frame);

}  // namespace tessera
