#pragma once

#include <array>
#include <optional>
#include <string>

#include "proto/tessera/v1/scene.pb.h"

namespace tessera {

/// A camera as a pointer moves it: where it is, what it looks at, which way is up. Metres, world
/// axes.
struct FreeCamera {
  std::array<double, 3> eye{}, target{}, up{0, 1, 0};
  double fov = 45;                       ///< degrees, in (0, 180)
  std::string axis = "smaller";          ///< the side that `fov` spans: also vertical ...
  std::optional<double> orthographic{};  ///< the window's height in metres, in place of `fov`
  friend bool operator==(const FreeCamera&, const FreeCamera&) = default;
};

/// Has the scene seen by that camera alone. It keeps the lens and the bounds of the one that is
/// called `name`, as of `--camera`, and turns where that is a panorama.
void use_free_camera(v1::Scene& scene, const std::string& name, const FreeCamera& camera);

}  // namespace tessera
