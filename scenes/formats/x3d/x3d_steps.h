#pragma once

#include "proto/tessera/v1/scene.pb.h"
#include "renderer/math/vec.h"
#include "scenes/formats/x3d/document/x3d_values.h"
#include "scenes/import/put_vec3.h"

namespace tessera {

/// Adds a step unless it does nothing.
void add_translation(const Vec3& by, v1::Transform& out);
void add_rotation(const X3dRotation& turn, v1::Transform& out);

/// From where a file without a viewpoint is seen: as a model without a camera, all of it.
v1::Camera default_camera();

/// How much longer lengths become: the cube root of the volume's factor.
double mean_scale(const v1::Transform& transform);

}  // namespace tessera
