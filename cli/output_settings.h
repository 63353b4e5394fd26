#pragma once

#include "proto/tessera/v1/scene.pb.h"
#include "renderer/film/tone_map.h"

namespace tessera {

/// What the scene asks of its picture. Throws scene_error for numbers out of their range.
OutputSettings output_settings(const v1::Output& output);

}  // namespace tessera
