#pragma once

#include <string>

#include "proto/tessera/v1/scene.pb.h"
#include "renderer/film/tone_map.h"

namespace tessera {

/// What the scene in that file asks of its picture. Throws scene_error for numbers out of their
/// range.
OutputSettings output_settings(const std::string& scene_file, const v1::Output& output);

}  // namespace tessera
