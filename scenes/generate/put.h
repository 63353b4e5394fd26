#pragma once

#include "proto/tessera/v1/scene.pb.h"

namespace tessera {

inline void put(double r, double g, double b, v1::Color* out) {
  out->set_r(r);
  out->set_g(g);
  out->set_b(b);
}

inline void put(double x, double y, double z, v1::Vec3* out) {
  out->set_x(x);
  out->set_y(y);
  out->set_z(z);
}

}  // namespace tessera
