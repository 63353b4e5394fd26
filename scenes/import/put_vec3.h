#pragma once

#include "proto/tessera/v1/scene.pb.h"
#include "renderer/math/vec.h"

namespace tessera {

inline void put_vec3(const Vec3& v, v1::Vec3* out) {
  out->set_x(v.x);
  out->set_y(v.y);
  out->set_z(v.z);
}

}  // namespace tessera
