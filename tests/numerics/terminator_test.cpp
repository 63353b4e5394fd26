// N25: smooth normals on few triangles shade smoothly into the dark.
#include <gtest/gtest.h>

#include <algorithm>

#include "renderer/render/tile_renderer.h"
#include "scenes/generate/generate_scene.h"

namespace tessera {
namespace {

constexpr int kWidth = 512;

/// A white ball of 20 * 4^subdivisions triangles, turned by `turn` degrees, in light from +x and
/// seen along the z axis: the middle row of the picture.
std::vector<float> middle_row(int subdivisions, double turn) {
  const MeshData ball = icosphere(subdivisions, true);
  v1::Scene scene;
  v1::Camera& camera = *scene.add_cameras();
  camera.mutable_orthographic();
  camera.mutable_world_from_camera()->add_steps()->mutable_translate()->set_z(5);
  v1::Material& white = *scene.add_materials();
  white.set_name("white");
  v1::Color& color = *white.mutable_classic()->mutable_diffuse()->mutable_value();
  color.set_r(1);
  color.set_g(1);
  color.set_b(1);
  scene.add_nodes()->mutable_light()->mutable_directional()->mutable_direction()->set_x(-1);
  v1::Node& node = *scene.add_nodes();
  v1::AxisAngle& turned = *node.mutable_transform()->add_steps()->mutable_rotate();
  turned.mutable_axis()->set_x(1);
  turned.mutable_axis()->set_y(2);
  turned.mutable_axis()->set_z(3);
  turned.set_angle(turn);
  v1::Shape& shape = *node.mutable_shape();
  shape.add_materials("white");
  v1::TriangleMesh& mesh = *shape.mutable_mesh();
  mesh.mutable_inline_positions()->Add(ball.positions.begin(), ball.positions.end());
  mesh.mutable_inline_normals()->Add(ball.normals.begin(), ball.normals.end());
  mesh.mutable_inline_triangles()->Add(ball.triangles.begin(), ball.triangles.end());
  v1::FrameSettings frame;
  frame.set_width(kWidth);
  frame.set_height(kWidth);
  frame.set_samples_per_pixel(1);
  const auto renderer = make_tile_renderer(scene, {}, frame, 1);
  TileProgress progress;
  const auto tile = renderer->render({{0, kWidth / 2, kWidth, kWidth / 2 + 1}, 0, 1}, progress);
  std::vector<float> row;
  for (size_t i = 0; i < tile->values.size(); i += 3) row.push_back(tile->values[i]);
  return row;
}

class N25 : public testing::TestWithParam<int> {};

TEST_P(N25, LightGrowsSmoothlyAcrossTheTerminator) {
  for (const double turn : {0.0, 10.0, 25.0, 40.0}) {
    const std::vector<float> row = middle_row(GetParam(), turn);
    const float peak = *std::max_element(row.begin(), row.end());
    EXPECT_NEAR(peak, 1, 0.1);
    // Around the terminator, well inside of the outline.
    for (int x = kWidth / 2 - kWidth / 5; x < kWidth / 2 + kWidth / 5; ++x) {
      const float step = row[static_cast<size_t>(x) + 1] - row[static_cast<size_t>(x)];
      ASSERT_GE(step, -1e-6f) << "at " << x;
      ASSERT_LE(step, 0.02f * peak) << "at " << x;
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Subdivisions, N25, testing::Range(1, 7));

}  // namespace
}  // namespace tessera
