#include "studio/scene_extent.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "renderer/math/vec.h"

namespace tessera {
namespace {

Point3 point(const std::array<double, 3>& p) { return {p[0], p[1], p[2]}; }

TEST(SceneExtent, ACameraThatFramesAllIsWhereItSeesTheBox) {
  v1::Camera camera;
  v1::LookAt& look_at = *camera.mutable_world_from_camera()->add_steps()->mutable_look_at();
  look_at.mutable_eye()->set_z(5);
  look_at.mutable_target();
  const Bounds3 bounds{{100, -1, -1}, {102, 1, 1}};
  EXPECT_EQ(free_camera_of(camera, bounds).eye, (std::array<double, 3>{0, 0, 5}));

  camera.set_frame_all(true);
  const FreeCamera framed = free_camera_of(camera, bounds);
  const Point3 eye = point(framed.eye);
  const Vec3 forward = normalize(point(framed.target) - eye);
  EXPECT_NEAR(forward.z, -1, 1e-12);
  double highest = 0;
  for (const double x : {100., 102.}) {
    for (const double y : {-1., 1.}) {
      for (const double z : {-1., 1.}) {
        const Vec3 to_corner = Point3{x, y, z} - eye;
        highest = std::max(highest, std::abs(to_corner.y) / dot(to_corner, forward));
        EXPECT_GT(dot(to_corner, forward), 0);
      }
    }
  }
  // By the 45 degrees that a camera has of itself: all is seen, and fills most of the height.
  const double edge = std::tan(std::numbers::pi / 8);
  EXPECT_LT(highest, edge);
  EXPECT_GT(highest, 0.8 * edge);
}

}  // namespace
}  // namespace tessera
