#pragma once

#include "proto/tessera/v1/scene.pb.h"
#include "renderer/film/tone_map.h"

namespace tessera {

/// How that output makes numbers of light. Throws scene_error for numbers out of their range.
OutputSettings picture_settings(const v1::Output& output);

}  // namespace tessera
