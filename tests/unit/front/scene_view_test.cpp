#include "front/scene_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "front/load_frame.h"
#include "proto/wire/scene_codec.h"
#include "renderer/camera/camera.h"
#include "renderer/math/transform.h"
#include "renderer/scene/read_camera.h"
#include "renderer/shapes/outline_points.h"
#include "tests/error_of.h"

namespace tessera {
namespace {

constexpr char kBox[] =
    "cameras { name: 'own' world_from_camera { steps { translate { z: 40 } } } "
    "  headlight { directional { direction { z: -1 } } intensity: 0.25 } } "
    "nodes { shape { plane { offset: -9 } } } "
    "nodes { shape { box { min { x: 10 y: 1 z: -2 } max { x: 16 y: 3 z: -1 } } } } ";
const Bounds3 kExtent{{10, 1, -2}, {16, 3, -1}};

LoadedScene seen(const RenderOptions& options, const std::string& text = kBox) {
  return load_frame(options, decode_scene(text, SceneEncoding::text, "made"), 0);
}

RenderOptions from(const std::string& view) {
  RenderOptions options;
  options.view = view;
  return options;
}

Vec3 rounded(const Vec3& v) {
  return {std::round(v.x * 1e9) / 1e9, std::round(v.y * 1e9) / 1e9, std::round(v.z * 1e9) / 1e9};
}

Camera camera_of(const v1::Scene& scene, double time) {
  return Camera(read_camera(scene, "", time).settings, 200, 100);
}

TEST(SceneView, LooksFromThereAtAllThatThereIs) {
  struct Case {
    const char* view;
    Vec3 along, up;
  };
  for (const Case& each : {Case{"front", {0, 0, -1}, {0, 1, 0}}, Case{"back", {0, 0, 1}, {0, 1, 0}},
                           Case{"right", {-1, 0, 0}, {0, 1, 0}}, Case{"left", {1, 0, 0}, {0, 1, 0}},
                           Case{"side", {-1, 0, 0}, {0, 1, 0}}, Case{"top", {0, -1, 0}, {0, 0, -1}},
                           Case{"bottom", {0, 1, 0}, {0, 0, 1}}}) {
    SCOPED_TRACE(each.view);
    RenderOptions options = from(each.view);
    const v1::Scene y = seen(options).scene;
    ASSERT_EQ(y.cameras_size(), 1);
    EXPECT_TRUE(y.cameras(0).frame_all());
    EXPECT_EQ(y.cameras(0).headlight().intensity(), 0.25);
    EXPECT_EQ(rounded(camera_of(y, 0).view()), each.along);
    EXPECT_EQ(rounded(camera_of(y, 0).up()), each.up);

    options.reading.up = ReadOptions::Up::z;
    const LoadedScene z = seen(options);
    EXPECT_TRUE(z.warnings.empty());
    const auto turned = [](const Vec3& v) { return Vec3{v.x, -v.z, v.y}; };
    EXPECT_EQ(rounded(camera_of(z.scene, 0).view()), turned(each.along));
    EXPECT_EQ(rounded(camera_of(z.scene, 0).up()), turned(each.up));
  }
}

TEST(SceneView, UpIsWhereTheFirstCameraHasIt) {
  const std::string text =
      "cameras { world_from_camera { steps { look_at { eye { x: 9 } up { z: 2 } } } } }";
  RenderOptions options = from("front");
  EXPECT_EQ(rounded(camera_of(seen(options, text).scene, 0).up()), (Vec3{0, 0, 1}));
  options.reading.up = ReadOptions::Up::y;
  EXPECT_EQ(rounded(camera_of(seen(options, text).scene, 0).up()), (Vec3{0, 1, 0}));
}

TEST(SceneView, LeavesASceneAsItIsWithoutThem) {
  RenderOptions options;
  EXPECT_EQ(seen(options).scene.cameras(0).name(), "own");
  options.reading.up = ReadOptions::Up::z;
  EXPECT_EQ(seen(options).warnings.size(), 1u);
}

TEST(SceneView, TurntablesSeeAllFromOneDistance) {
  for (const bool z_is_up : {false, true}) {
    for (const char* view : {"", "front", "top"}) {
      SCOPED_TRACE(std::string(view) + (z_is_up ? " z" : " y"));
      RenderOptions options;
      options.size = FrameSize{200, 100};
      options.turntable = 12;
      if (*view) options.view = view;
      if (z_is_up) options.reading.up = ReadOptions::Up::z;
      const v1::Scene scene = seen(options).scene;
      ASSERT_EQ(scene.cameras_size(), 1);
      const Vec3 axis = z_is_up ? Vec3{0, 0, 1} : Vec3{0, 1, 0};
      const Vec3 first = camera_of(scene, 0).position() - kExtent.center();
      double nearest_edge = 200;
      for (int frame = 0; frame < 12; ++frame) {
        const Camera camera = camera_of(scene, frame / 24.0);
        const Vec3 eye = camera.position() - kExtent.center();
        EXPECT_NEAR(length(eye), length(first), 1e-9);
        EXPECT_NEAR(dot(eye, axis), dot(first, axis), 1e-9);
        const Vec3 expected = rotation(axis, frame * 2 * M_PI / 12)(first);
        EXPECT_NEAR(length(eye - expected), 0, 1e-6);
        for (const Point3& corner : box_corners(kExtent)) {
          const auto at = camera.raster_of(corner);
          ASSERT_TRUE(at);
          nearest_edge = std::min({nearest_edge, at->x, at->y, 200 - at->x, 100 - at->y});
        }
      }
      EXPECT_GT(nearest_edge, 0);
      EXPECT_LT(nearest_edge, 12) << "it fills the picture in some frame";
    }
  }
}

TEST(SceneView, TurntablesOfNothingStandSomewhere) {
  RenderOptions options;
  options.turntable = 3;
  EXPECT_EQ(rounded(camera_of(seen(options, "settings { width: 8 }").scene, 0).up()),
            rounded(camera_of(seen(from("iso"), "settings { width: 8 }").scene, 0).up()));
}

TEST(SceneView, AnAutomaticCameraSeesAllAsWhereThereIsNone) {
  const std::string named = std::string(kBox) + "cameras { name: 'auto' }";
  RenderOptions options;
  options.camera = "auto";
  for (const std::string& text : {std::string(kBox), named}) {
    v1::Scene scene = seen(options, text).scene;
    ASSERT_EQ(scene.cameras_size(), 1);
    EXPECT_EQ(frame_settings(options, scene, std::nullopt).camera(), "auto");
    scene.mutable_cameras(0)->set_name("iso");
    EXPECT_EQ(scene.cameras(0).DebugString(),
              seen(from("iso"), text).scene.cameras(0).DebugString());
  }
  options.reading.up = ReadOptions::Up::z;
  EXPECT_TRUE(seen(options).warnings.empty()) << "--up turns it";
  options.view = "top";
  EXPECT_NE(usage_error_of([&] { seen(options); }), "");
}

TEST(SceneView, IsNoneOfTheScenesCameras) {
  RenderOptions options = from("front");
  options.camera = "own";
  EXPECT_EQ(usage_error_of([&] { seen(options); }),
            "--view: is a camera in place of the scene's; expected no --camera");
  options.view.reset();
  options.turntable = 2;
  EXPECT_EQ(usage_error_of([&] { seen(options); }),
            "--turntable: has a camera of its own; expected no --camera");
}

TEST(SceneView, TurntablesHaveFramesOfTheirOwn) {
  const std::string wrong = "--turntable: has frames of its own; expected no --frames beside it";
  for (const bool turntable_first : {false, true}) {
    RenderOptions options;
    OptionList list;
    add_render_options(list, options);
    const auto assign = [&](bool turntable) {
      assign_option(list, turntable ? "turntable" : "frames", std::string("3"));
    };
    assign(turntable_first);
    EXPECT_EQ(usage_error_of([&] { assign(!turntable_first); }), wrong);
    EXPECT_EQ(options.frames, turntable_first ? (FrameNumbers{0, 1, 2}) : FrameNumbers{3});
  }
}

}  // namespace
}  // namespace tessera
