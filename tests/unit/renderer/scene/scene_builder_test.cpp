#include "renderer/scene/scene_builder.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/error.h"
#include "renderer/math/elementary.h"
#include "renderer/scene/read_transform.h"
#include "tests/unit/renderer/scene_text.h"

namespace tessera {
namespace {

std::shared_ptr<const Scene> build(const std::string& text, const BlobStore& blobs = {}) {
  return build_scene(parse_scene(text), blobs, frame_of(8, 8), 2);
}

TEST(Scene, keeps_only_what_the_picture_needs) {
  const auto scene = build(R"(
    materials { name: 'used' } materials { name: 'unused' classic { shininess { value: nan } } }
    materials { name: 'back' } materials { name: 'sided' sides: BACK_MATERIAL back: 'back' }
    objects { name: 'o' nodes { shape { materials: 'used' sphere {} } } } objects { name: 'p' }
    nodes { instance_of: 'o' } nodes { instance_of: 'o' transform { steps { translate { x: 3 } } } }
    nodes { shape { materials: 'sided' box {} } }
    nodes { hidden: true shape { sphere {} } light { point {} } }
    nodes { transform { steps { scale { x: 1 y: 0 z: 1 } } } shape { sphere {} } }
    nodes { light { off: true point {} } } nodes { light { point {} } })");
  EXPECT_EQ(scene->counters.at("materials_total"), 4u);
  EXPECT_EQ(scene->counters.at("materials_used"), 3u);
  EXPECT_EQ(scene->counters.at("objects_total"), 2u);
  EXPECT_EQ(scene->counters.at("objects_used"), 1u);
  EXPECT_EQ(scene->counters.at("shapes"), 2u);
  EXPECT_EQ(scene->counters.at("instances"), 3u);
  EXPECT_EQ(scene->counters.at("nodes_hidden"), 1u);
  EXPECT_EQ(scene->counters.at("nodes_flat"), 1u);
  EXPECT_EQ(scene->counters.at("lights_used"), 1u);
  EXPECT_EQ(scene->counters.at("lights_off"), 1u);
  EXPECT_EQ(scene->instances[0].shape, scene->instances[1].shape);
}

TEST(Scene, a_mesh_that_lives_is_not_read_again) {
  constexpr uint32_t kTriangles = 5000;
  v1::Scene scene;
  BlobStore blobs;
  v1::TriangleMesh& mesh = *scene.add_nodes()->mutable_shape()->mutable_mesh();
  const auto put = [&](v1::BlobRef& ref, const auto& numbers) {
    std::vector<std::byte> bytes(numbers.size() * sizeof(numbers[0]));
    std::memcpy(bytes.data(), numbers.data(), bytes.size());
    ref.set_size(bytes.size());
    ref.set_digest(blobs.put(std::move(bytes)).hex());
  };
  std::vector<float> positions;
  std::vector<uint32_t> triangles;
  for (uint32_t i = 0; i < kTriangles; ++i) {
    const auto x = static_cast<float>(i);
    positions.insert(positions.end(), {x, 0, 0, x + 1, 0, 0, x, 1, 0});
    triangles.insert(triangles.end(), {3 * i, 3 * i + 1, 3 * i + 2});
  }
  put(*mesh.mutable_positions(), positions);
  put(*mesh.mutable_triangles(), triangles);
  WeakCache live;
  const Sharing sharing{.live = &live};
  const auto build = [&](const BlobStore& from, const Sharing& where) {
    return build_scene(scene, from, frame_of(8, 8), 2, where);
  };
  auto first = build(blobs, sharing);
  // Where there are no blobs, none is read.
  const auto second = build({}, sharing);
  EXPECT_EQ(second->counters.at("triangles"), kTriangles);
  EXPECT_EQ(second->counters, first->counters);
  EXPECT_THROW(build({}, {}), Error);
  // What else a mesh is made from is another mesh.
  mesh.set_closed(true);
  EXPECT_THROW(build({}, sharing), Error);
  mesh.set_closed(false);
  EXPECT_NO_THROW(build({}, sharing));
}

TEST(Scene, lights_out_of_range_leave_the_others_alone) {
  const std::string seen = R"(
    cameras { world_from_camera { steps { translate { z: 3 } } } } nodes { shape { sphere {} } }
    nodes { light { directional { direction { z: -1 } } } } )";
  // Moved to infinity, and turned to no direction.
  const std::string far = R"(
    nodes { transform { steps { translate { x: 1.7e308 } } } light { point { position { x: 1.7e308 } } } }
    nodes { transform { steps { matrix { rows: [1.7e308, 1.7e308, 0, 0, -1e-300, 1e-300, 0, 0, 0, 0, 1e-8, 0] } } }
            light { directional { direction { x: 1 y: 1 } } } } )";
  const auto scene = build(seen + far);
  EXPECT_EQ(scene->counters.at("lights_off"), 2u);
  EXPECT_EQ(scene->lights.size(), 1u);
  const std::vector<float> expected = render_text(seen, 8, 8).values;
  EXPECT_GT(*std::ranges::max_element(expected), 0.1f);
  EXPECT_EQ(render_text(seen + far, 8, 8).values, expected);
}

TEST(Scene, scopes_hold_their_own_lights_only) {
  std::string text = "nodes { light { point {} } } nodes { shape { sphere {} } } ";
  for (int i = 0; i < 3; ++i) {
    text += "nodes { children { light { scoped: true point {} } } children { shape { box {} } } } ";
    text += "nodes { light { point {} } } ";
  }
  const auto scene = build(text);
  EXPECT_EQ(scene->global_lights.all().size(), 4u);
  ASSERT_EQ(scene->scoped_lights.size(), 4u);
  for (size_t i = 0; i < 4; ++i) EXPECT_EQ(scene->scoped_lights[i].size(), i == 0 ? 0u : 1u);
  for (uint32_t instance = 0; instance < 4; ++instance) {
    std::vector<uint32_t> seen;
    scene->for_each_light(instance, Point3{}, [&](uint32_t light) { seen.push_back(light); });
    EXPECT_EQ(seen.size(), instance == 0 ? 4u : 5u);
    EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
  }
}

TEST(Scene, planes_that_no_light_is_behind_are_left_out_of_shadow_rays) {
  const auto scene = [](const std::string& sides, const std::string& light) {
    return build("materials { name: 'm' " + sides + " } nodes { light { " + light +
                 " } } nodes { shape { materials: 'm' plane {} } } nodes { shape { sphere {} } }");
  };
  const auto left_out = [](const std::shared_ptr<const Scene>& built) {
    return built->counters.contains("planes_without_shadow");
  };
  const std::string above = "point { position { x: 3 y: 2 } }",
                    below = "point { position { y: -2 } }";
  const auto lit_from_above = scene("sides: FRONT_ONLY", above);
  EXPECT_TRUE(left_out(lit_from_above));
  EXPECT_EQ(lit_from_above->occluders.opaque->statistics().primitives, 1u);
  EXPECT_EQ(lit_from_above->surfaces->statistics().primitives, 2u);
  EXPECT_TRUE(left_out(scene("sides: FRONT_ONLY", "directional { direction { y: -1 } }")));
  EXPECT_FALSE(left_out(scene("sides: FRONT_ONLY", below)));
  EXPECT_FALSE(left_out(scene("sides: FRONT_ONLY", "directional { direction { y: 1 } }")));
  EXPECT_FALSE(left_out(scene("sides: FRONT_ONLY", "point { position { x: 5 } }")));
  EXPECT_FALSE(left_out(scene("", above)));
}

TEST(Scene, too_many_lights_are_refused) {
  std::string text = "objects { name: 'o' ";
  for (int i = 0; i < 400; ++i) text += "nodes { light { point {} } } ";
  text += "} ";
  for (int i = 0; i < 251; ++i) text += "nodes { instance_of: 'o' } ";
  try {
    build(text);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::bad_scene);
    EXPECT_NE(std::string(error.what()).find("100000 lights"), std::string::npos);
  }
}

TEST(Scene, knows_what_tracing_may_leave_out) {
  const std::string lamp = "nodes { light { point { position { y: 9 } } } } ";
  const std::string ball = "nodes { shape { materials: 'm' sphere {} } } ";
  const auto features = [&](const std::string& text) { return build(text)->features; };
  EXPECT_FALSE(features("materials { name: 'm' } " + ball).shadows);
  EXPECT_FALSE(features(lamp).shadows);
  EXPECT_TRUE(features(lamp + "materials { name: 'm' } " + ball).shadows);
  const auto scene =
      build(lamp + "materials { name: 'm' classic { transparency { value: .1 } } } " + ball +
            "nodes { shape { sphere {} } }");
  EXPECT_EQ(scene->occluders.clear_instances, (std::vector<uint32_t>{0}));
  EXPECT_NE(scene->occluders.opaque, scene->surfaces);
  const auto opaque = build(lamp + "nodes { shape { sphere {} } }");
  EXPECT_EQ(opaque->occluders.opaque, opaque->surfaces);
  EXPECT_EQ(opaque->occluders.clear, nullptr);
}

TEST(Scene, degenerate_triangles_are_dropped_and_counted) {
  const auto scene = build(
      "nodes { shape { mesh { inline_positions: [0,0,0, 1,0,0, 0,1,0] "
      "inline_triangles: [0,1,2, 0,0,1] } } } "
      "nodes { shape { mesh { inline_positions: [0,0,0] "
      "inline_triangles: [0,0,0] } } }");
  EXPECT_EQ(scene->counters.at("triangles"), 1u);
  EXPECT_EQ(scene->counters.at("triangles_dropped"), 2u);
  EXPECT_EQ(scene->instances.size(), 1u);
}

TEST(Scene, meshes_of_blobs_and_of_numbers_are_one) {
  const float positions[] = {-9, -9, 0, 9, -9, 0, 0, 9, 0};
  const float colors[] = {1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1};
  const uint32_t triangles[] = {0, 1, 2}, faces[] = {1};
  BlobStore blobs;
  const auto put = [&](v1::BlobRef& ref, const void* data, size_t size) {
    std::vector<std::byte> bytes(size);
    std::memcpy(bytes.data(), data, size);
    ref.set_digest(blobs.put(std::move(bytes)).hex());
    ref.set_size(size);
  };
  v1::Scene scene = parse_scene(
      "materials { name: 'a' } materials { name: 'b' unlit { color { value "
      "{ r: .5 g: .5 b: .5 } } } } nodes { shape { materials: ['a', 'b'] mesh {} } }");
  v1::TriangleMesh& mesh = *scene.mutable_nodes(0)->mutable_shape()->mutable_mesh();
  put(*mesh.mutable_positions(), positions, sizeof positions);
  put(*mesh.mutable_triangles(), triangles, sizeof triangles);
  put(*mesh.mutable_colors(), colors, sizeof colors);
  put(*mesh.mutable_face_materials(), faces, sizeof faces);
  const auto renderer = make_tile_renderer(scene, blobs, frame_of(1, 1), 1);
  EXPECT_EQ(render_rect(*renderer, {0, 0, 1, 1}).values, (std::vector<float>{.5f, 0, 0}));
}

TEST(Scene, vertex_alpha_lets_what_is_behind_show) {
  const float positions[] = {-9, -9, 0, 9, -9, 0, 0, 9, 0};
  const float colors[] = {1, 0, 0, .25f, 1, 0, 0, .25f, 1, 0, 0, .25f};
  BlobStore blobs;
  std::vector<std::byte> bytes(sizeof colors);
  std::memcpy(bytes.data(), colors, sizeof colors);
  v1::Scene scene = parse_scene(
      "background { solid { b: 1 } } materials { name: 'a' unlit {} } nodes { "
      "shape { materials: 'a' mesh { inline_triangles: [0,1,2] } } }");
  v1::TriangleMesh& mesh = *scene.mutable_nodes(0)->mutable_shape()->mutable_mesh();
  for (const float p : positions) mesh.add_inline_positions(p);
  mesh.mutable_colors()->set_digest(blobs.put(std::move(bytes)).hex());
  mesh.mutable_colors()->set_size(sizeof colors);
  const auto renderer = make_tile_renderer(scene, blobs, frame_of(1, 1), 1);
  EXPECT_EQ(render_rect(*renderer, {0, 0, 1, 1}).values, (std::vector<float>{.25f, 0, .75f}));
}

TEST(ReadTransform, steps_compose_as_written) {
  v1::Transform transform;
  ASSERT_TRUE(google::protobuf::TextFormat::ParseFromString(
      "steps { translate { x: 5 } } steps { rotate { axis { z: 2 } angle: 90 } } "
      "steps { scale { x: 2 y: 1 z: 1 } } ",
      &transform));
  const Point3 p = read_transform({.kind = "t"}, transform)(Point3{1, 1, 0});
  EXPECT_NEAR(p.x, 4, 1e-15);
  EXPECT_NEAR(p.y, 2, 1e-15);
}

Affine at(const std::string& keys, double time) {
  v1::Node node;
  EXPECT_TRUE(google::protobuf::TextFormat::ParseFromString(keys, &node));
  return read_transform({.kind = "node"}, node.transform(), node.keys(), time);
}

TEST(ReadTransform, rotations_turn_at_constant_speed) {
  const std::string about_one_axis =
      "keys { transform { steps { rotate { axis { y: 1 } angle: 0 } } } } "
      "keys { time: 4 transform { steps { rotate { axis { y: 1 } angle: 720 } } } }";
  const Vec3 quarter = at(about_one_axis, 0.5)(Vec3{1, 0, 0});
  EXPECT_NEAR(quarter.x, 0, 1e-15);
  EXPECT_NEAR(quarter.z, -1, 1e-15);
  // From a quarter about x to a quarter about y: halfway, the turn from either is the same.
  const std::string between =
      "keys { transform { steps { rotate { axis { x: 1 } angle: 90 } } } } "
      "keys { time: 1 transform { steps { rotate { axis { y: 1 } angle: 90 } } } }";
  const auto angle_between = [](const Affine& a, const Affine& b) {
    double trace = 0;
    for (size_t i = 0; i < 3; ++i) {
      for (size_t j = 0; j < 3; ++j) trace += a.m[i][j] * b.m[i][j];
    }
    return std::acos(std::min(1.0, (trace - 1) / 2));
  };
  const double whole = angle_between(at(between, 0), at(between, 1));
  EXPECT_NEAR(angle_between(at(between, 0), at(between, .25)), whole / 4, 1e-12);
  EXPECT_NEAR(angle_between(at(between, .25), at(between, 1)), whole * 3 / 4, 1e-12);
}

TEST(ReadTransform, an_axis_may_be_rounded_in_each_key) {
  const auto keys = [](const std::string& axis, const std::string& angle) {
    return "keys { transform { steps { rotate { axis { x: 1 y: 1 z: 1 } angle: 10 } } } } "
           "keys { time: 1 transform { steps { rotate { axis { " +
           axis + " } angle: " + angle + " } } } }";
  };
  const Affine expected = rotation({1, 1, 1}, portable::radians(190));
  for (const auto& [axis, angle] :
       {std::pair("x: 1 y: 1 z: 1", "370"), std::pair("x: .57735 y: .57735 z: .57735003", "370"),
        std::pair("x: -1 y: -1 z: -1.0000001", "-370")}) {
    const Affine half = at(keys(axis, angle), .5);
    for (size_t i = 0; i < 3; ++i)
      for (size_t j = 0; j < 3; ++j) EXPECT_NEAR(half.m[i][j], expected.m[i][j], 1e-6) << axis;
  }
}

void expect_near(const Vec3& a, const Vec3& b, double most, const char* what = "") {
  EXPECT_NEAR(length(a - b), 0, most) << a.x << ' ' << a.y << ' ' << a.z << ' ' << what;
}

TEST(ReadTransform, up_is_mixed_as_eye_and_target_are) {
  const auto view = [](const std::string& up) {
    return "transform { steps { look_at { eye { z: 5 } target { } " + up + " } } } } ";
  };
  const std::string roll =
      "keys { " + view("up { y: 1 }") + "keys { time: 1 " + view("up { x: 1 }");
  expect_near(at(roll, .5)(Vec3{0, 1, 0}), normalize(Vec3{1, 1, 0}), 1e-12);
  expect_near(at(roll, .25)(Vec3{0, 1, 0}), normalize(Vec3{1, 3, 0}), 1e-12);
  expect_near(at(roll, .9999999)(Vec3{0, 1, 0}), {1, 0, 0}, 1e-6, "no jump at the last key");
  const std::string from_default = "keys { " + view("") + "keys { time: 1 " + view("up { x: 1 }");
  expect_near(at(from_default, .5)(Vec3{0, 1, 0}), normalize(Vec3{1, 1, 0}), 1e-12);
  const std::string over =
      "keys { " + view("up { y: 1 }") + "keys { time: 1 " + view("up { y: -2 }");
  expect_near(at(over, .5)(Vec3{0, 1, 0}), {-1, 0, 0}, 1e-12, "about the view");
}

TEST(ReadTransform, a_view_turns_evenly_from_one_target_to_another) {
  const auto view = [](const Point3& eye, double degrees) {
    const double angle = portable::radians(degrees);
    return fmt::format(
        "transform {{ steps {{ look_at {{ eye {{ x: {} y: {} z: {} }} target {{ x: {} y: {} z: {} "
        "}} }} }} }} ",
        eye.x, eye.y, eye.z, eye.x - 5 * std::sin(angle), eye.y, eye.z - 5 * std::cos(angle));
  };
  for (const double degrees : {60., 120., 179., 180.}) {
    const std::string pan =
        "keys { " + view({1, 2, 3}, 0) + "} keys { time: 1 " + view({3, 2, 3}, degrees) + "}";
    for (const double s : {.1, .25, .5, .9}) {
      const Affine now = at(pan, s);
      expect_near(now(Point3{}) - Point3{}, {1 + 2 * s, 2, 3}, 1e-12);
      expect_near(now(Vec3{0, 1, 0}), {0, 1, 0}, 1e-12, "about one axis");
      const Vec3 forward = now(Vec3{0, 0, -1});
      EXPECT_NEAR(portable::degrees(std::acos(-forward.z)), s * degrees, 1e-6) << degrees;
    }
  }
}

std::string matrix_keys(const Affine& first, const Affine& last) {
  const auto step = [](const Affine& a) {
    std::string text = "transform { steps { matrix { rows: [";
    for (const auto& row : a.m)
      for (const double value : row)
        text += fmt::format("{}{}", text.back() == '[' ? "" : ",", value);
    return text + "] } } } }";
  };
  return "keys { " + step(first) + " keys { time: 1 " + step(last);
}

TEST(ReadTransform, matrices_turn_and_keep_their_size) {
  const Affine size = scaling({2, 3, 4});
  for (const double degrees : {30., 90., 179., 180.}) {
    const Affine to =
        translation({8, 0, 0}) * rotation({0, 0, 1}, portable::radians(degrees)) * size;
    const Affine half = at(matrix_keys(size, to), .5);
    const Affine expected =
        translation({4, 0, 0}) * rotation({0, 0, 1}, portable::radians(degrees / 2)) * size;
    for (int a = 0; a < 3; ++a) {
      Vec3 axis;
      axis[a] = 1;
      EXPECT_NEAR(length(half(axis)), length(expected(axis)), 1e-12) << degrees;
      if (degrees < 180) expect_near(half(axis), expected(axis), 1e-12);
    }
    EXPECT_NEAR(half.m[0][3], 4, 1e-12);
  }
  // What mirrors, and what is tiny.
  for (const Affine& scale : {scaling({-1, 1, 1}), scaling({1e-100, 1e-100, 1e-100})}) {
    const Affine to = rotation({1, 2, 3}, 1) * scale;
    const Affine half = at(matrix_keys(scale, to), .5), expected = rotation({1, 2, 3}, .5) * scale;
    const double least = std::abs(scale.m[0][0]) * 1e-12;
    expect_near(half(Vec3{1, 0, 0}), expected(Vec3{1, 0, 0}), least);
    expect_near(half(Vec3{0, 1, 1}), expected(Vec3{0, 1, 1}), 2 * least);
  }
  // A flat one has no turn of its own.
  const Affine flat = at(matrix_keys(scaling({1, 0, 1}), scaling({1, 1, 1})), .5);
  EXPECT_EQ(flat.m[1][1], .5);
  EXPECT_EQ(at(matrix_keys({}, translation({1, 2, 3})), .5), translation({.5, 1, 1.5}));
}

}  // namespace
}  // namespace tessera
