#pragma once

#include "proto/tessera/v1/farm.pb.h"
#include "proto/tessera/v1/scene.pb.h"

namespace tessera {

/// Whether anything in the scene depends on the instant that is rendered: only keys of transforms
/// can.
bool moves(const v1::Scene& scene);

/// `frame` without what the pixels of this scene do not depend on: the instant, where nothing
/// moves.
v1::FrameSettings settled(const v1::FrameSettings& frame, bool scene_moves);

}  // namespace tessera
