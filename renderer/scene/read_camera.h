#pragma once

#include <string>

#include "proto/tessera/v1/scene.pb.h"
#include "renderer/camera/camera.h"
#include "renderer/math/transform.h"
#include "renderer/shading/light.h"

namespace tessera {

struct CameraChoice {
  CameraSettings settings;
  /// Sits in the camera's frame.
  const v1::Light* headlight = nullptr;
  bool frame_all = false;
};

/// The light that a camera at `world_from_camera` carries.
Light read_headlight(const v1::Light& light, const Affine& world_from_camera);

/// The camera called `name`, or described so, or of that number counting from 1; empty: the first.
/// Null where there is none.
const v1::Camera* find_camera(const v1::Scene& scene, const std::string& name);

/// The camera that find_camera finds, at `time`. Throws a scene error for an unknown one.
CameraChoice read_camera(const v1::Scene& scene, const std::string& name, double time);

}  // namespace tessera
