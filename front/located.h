#pragma once

#include <string>
#include <string_view>

#include "base/error.h"
#include "proto/wire/scene_codec.h"

namespace tessera {

/// An error of building the scene in that file, with its place there.
inline Error located(const std::string& scene_file, std::string_view message) {
  return scene_error(place_in_scene_file(scene_file, message), message, "");
}

}  // namespace tessera
