#include <fmt/format.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "renderer/math/elementary.h"
#include "scenes/edit/camera_numbers.h"
#include "scenes/edit/x3d_rotation.h"
#include "scenes/formats/gltf/gltf_reader.h"
#include "scenes/import/to_affine.h"
#include "tests/unit/scenes/edit/edit_testing.h"

namespace tessera::edit {
namespace {

constexpr std::string_view kLens =
    R"("cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "aspectRatio": 1.5, "znear": 0.1}}])";
const CameraPose kPose{{1, 2, 3}, {0, 0.5, 0.25}, {.1, 1, 0}, 40.0, "vertical", {}};

Outline gltf_text(std::string text) { return outline(Language::gltf, std::move(text)); }

/// A document whose node 0 has these members.
std::string document(const std::string& nodes, std::string_view lens = kLens) {
  return fmt::format(
      "{{\n  \"asset\": {{\"version\": \"2.0\"}},\n  {},\n  \"nodes\": [{}],\n  \"scenes\": "
      "[{{\"nodes\": [0]}}]\n}}\n",
      lens, nodes);
}

v1::Camera read_camera(const std::string& text, int index = 0) {
  const v1::Scene scene = parse_gltf(text, "made.gltf").scene;
  EXPECT_LT(index, scene.cameras_size()) << text;
  return index < scene.cameras_size() ? scene.cameras(index) : v1::Camera();
}

/// How far the camera that the text has is from the pose: its axes, and its eye in lengths of the
/// view, or of 1 if that is more.
double distance(const CameraPose& pose, const std::string& text, int index = 0) {
  const Affine wanted =
      look_at(Point3{} + to_vec(pose.eye), Point3{} + to_vec(pose.target), to_vec(pose.up));
  const Affine world = to_affine(read_camera(text, index).world_from_camera());
  EXPECT_GT(world.determinant(), 0) << text;
  const double unit = std::max(1.0, length(to_vec(pose.target) - to_vec(pose.eye)));
  return std::max(rotation_difference(wanted, seen_from(world)),
                  length(world(Point3{}) - wanted(Point3{})) / unit);
}

/// The text with the camera written, which has to be seen in it and not written again.
std::string written(const std::string& text, const CameraPose& pose = kPose,
                    std::string_view name = "") {
  const Outline made = gltf_text(text);
  const Change change = write_camera(made, name, pose);
  if (change.refusal) return change.refusal->found;
  const std::string after = applied(made, change);
  EXPECT_LT(distance(pose, after), 5e-6) << after;
  EXPECT_NEAR(read_camera(after).perspective().field_of_view(), *pose.field_of_view, 1e-5) << after;
  EXPECT_TRUE(write_camera(gltf_text(after), name, pose).edits.empty()) << after;
  const Outline there = gltf_text(after);
  EXPECT_EQ(there.entities()[static_cast<size_t>(change.entity)].type, "nodes");
  return after;
}

RC_GTEST_PROP(StudioEdit, WritesTheCameraOfAGltfText, ()) {
  const auto numbers = *rc::gen::container<std::vector<int>>(21, rc::gen::inRange(-4000, 4000));
  CameraPose pose;
  for (size_t i = 0; i < 3; ++i) {
    pose.eye[i] = numbers[i] / 977.0;
    pose.target[i] = pose.eye[i] + numbers[i + 3] / 1013.0;
    pose.up[i] = numbers[i + 6] / 300.0;
  }
  pose.field_of_view = 33.3;
  const Vec3 view = to_vec(pose.target) - to_vec(pose.eye), up = to_vec(pose.up);
  RC_PRE(length(view) > .1 && length(cross(view, up)) > .05 * length(view) * length(up));
  const auto turn = [&](size_t at) {
    const Vec3 axis{numbers[at] / 999.0, numbers[at + 1] / 999.0, 1};
    const double angle = numbers[at + 2] / 1000.0, sine = std::sin(angle / 2) / length(axis);
    return fmt::format("\"rotation\": [{}, {}, {}, {}]", sine * axis.x, sine * axis.y,
                       sine * axis.z, std::cos(angle / 2));
  };
  const auto size = [&](size_t at) { return 0.2 + std::abs(numbers[at]) / 1500.0; };
  const std::string parent =
      fmt::format(R"({{"children": [1], "translation": [{}, 2, {}], {}, "scale": [{}, 1, {}]}})",
                  numbers[9] / 500.0, numbers[10] / 500.0, turn(11), size(14), size(15));
  const std::string own =
      *rc::gen::arbitrary<bool>()
          ? fmt::format(R"("translation": [1, 2, 3], {}, "scale": [2, {}, 1])", turn(16), size(19))
          : fmt::format(R"("matrix": [0, 0, -1, 0, 0, 2, 0, 0, 1, 0, 0, 0, {}, 1, 0, 1])",
                        numbers[20] / 100.0);
  const std::string text = document(parent + ", {\"camera\": 0, " + own + "}");
  const Outline outline = gltf_text(text);
  const std::string made = applied(outline, write_camera(outline, "", pose));
  RC_ASSERT(distance(pose, made) <= 2e-6);
  RC_ASSERT(std::abs(read_camera(made).perspective().field_of_view() - 33.3) < 1e-5);
  RC_ASSERT(write_camera(gltf_text(made), "", pose).edits.empty());
}

TEST(StudioEdit, WritesTheNumbersOfAGltfCameraAlone) {
  const CameraPose pose{{1, 2, 3}, {1, 2, 0}, {0, 1, 0}, 40.0, "vertical", {}};
  EXPECT_EQ(written(document(R"({ "camera": 0, "translation": [1.0, 5e0, 3] })"), pose),
            document(R"({ "camera": 0, "translation": [1.0, 2, 3] })",
                     R"("cameras": [{"type": "perspective", "perspective": {"yfov": 0.6981317, )"
                     R"("aspectRatio": 1.5, "znear": 0.1}}])"));
  const std::string moved = written(
      document(
          R"({"camera": 0, "matrix": [1.0, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 1.0, 0, 7, 2.0, 7, 1]})"),
      pose);
  EXPECT_NE(moved.find(R"("matrix": [1.0, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 1.0, 0, 1, 2.0, 3, 1])"),
            std::string::npos)
      << moved;
  const std::string turned = written(document(R"({"camera":0})"));
  EXPECT_NE(turned.find(R"({"camera":0, "translation": [1, 2, 3], "rotation": [)"),
            std::string::npos)
      << turned;
  const std::string lines = written(document("\n    {\n      \"camera\": 0\n    }\n  "), pose);
  EXPECT_NE(lines.find("      \"camera\": 0,\n      \"translation\": [1, 2, 3]\n    }"),
            std::string::npos)
      << lines;
}

TEST(StudioEdit, WritesAGltfCameraInsideOfTransforms) {
  for (const char* const own :
       {R"("scale": [-1, 1, -2])", R"("scale": [-1, -1, 3], "rotation": [0, 0, 1, 0])",
        R"("matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])", R"("name": "a")"})
    written(document(fmt::format(R"({{"camera": 0, {}}})", own)));
  written(
      document(R"({"scale": [1, -1, 1], "children": [1]}, {"camera": 0, "scale": [1, 1, -1]})"));
  const auto refused = [](const std::string& nodes, const char* why) {
    EXPECT_EQ(written(document(nodes)), why);
  };
  refused(R"({"scale": [1, -1, 1], "children": [1]}, {"camera": 0})",
          "a camera in a transform that mirrors, as its picture would be");
  refused(R"({"matrix": [1, 2], "children": [1]}, {"camera": 0})",
          "a transform around the camera that cannot be read");
  for (const char* const more : {R"("children": [1])", R"("mesh": 0)",
                                 R"("extensions": {"KHR_lights_punctual": {"light": 0}})"})
    refused(fmt::format(R"({{"camera": 0, {}}}, {{}})", more),
            "a camera whose node holds more, which would move with it");
}

TEST(StudioEdit, WritesTheGltfCameraOfThatName) {
  const std::string text = document(
      R"({"children": [1, 2, 3]}, {"name": "a", "camera": 0}, {"name": "b", "camera": 1}, {"camera": 1})",
      R"("cameras": [{"type": "perspective", "perspective": {"yfov": 0.5}}, )"
      R"({"type": "perspective", "perspective": {"yfov": -0.5}}])");
  CameraPose pose = kPose;
  const auto write = [&](std::string_view name) {
    const Outline made = gltf_text(text);
    const Change change = write_camera(made, name, pose);
    return change.refusal ? change.refusal->found : applied(made, change);
  };
  EXPECT_LT(distance(pose, write("a")), 5e-6);
  EXPECT_LT(distance(pose, write("1")), 5e-6);
  EXPECT_EQ(write("c"), "no camera 'c'");
  EXPECT_EQ(write("b"), "another lens of a camera that 2 nodes show");
  pose.field_of_view = portable::degrees(0.5);
  EXPECT_LT(distance(pose, write("b"), 1), 5e-6);
  EXPECT_LT(distance(pose, write("camera 1"), 2), 5e-6);
}

TEST(StudioEdit, AddsACameraToAGltfTextWithoutOne) {
  const CameraPose pose{{1, 2, 3}, {1, 2, 0}, {0, 1, 0}, 40.0, "vertical", {}};
  EXPECT_EQ(written("{\n  \"asset\": {\"version\": \"2.0\"},\n  \"nodes\": [\n    {}\n  ],\n"
                    "  \"scenes\": [{\"nodes\": [0]}]\n}\n",
                    pose),
            "{\n  \"asset\": {\"version\": \"2.0\"},\n  \"nodes\": [\n    {},\n"
            "    {\"camera\": 0, \"translation\": [1, 2, 3]}\n  ],\n"
            "  \"scenes\": [{\"nodes\": [0, 1]}],\n"
            "  \"cameras\": [{\"type\": \"perspective\", \"perspective\": {\"yfov\": 0.6981317, "
            "\"znear\": 0.01}}]\n}\n");
  EXPECT_EQ(written(R"({"asset":{"version":"2.0"}})", pose),
            R"({"asset":{"version":"2.0"},"cameras":[{"type":"perspective","perspective":)"
            R"({"yfov":0.6981317,"znear":0.01}}],"nodes":[{"camera":0,"translation":[1,2,3]}]})");
  written(
      R"({"asset":{"version":"2.0"},"cameras":[{"type":"perspective"}],"scenes":[{},{}],"scene":1})");
  EXPECT_EQ(written(R"({"asset":{"version":"2.0"},"nodes":7})"), "'nodes' that is no list");
}

TEST(StudioEdit, AGltfAngleIsOverTheHeight) {
  const std::string text = document(R"({"camera": 0})");
  const auto yfov = [&](const std::string& axis, double aspect) {
    CameraPose pose = kPose;
    pose.axis = axis, pose.aspect = aspect;
    const Outline made = gltf_text(text);
    const Change change = write_camera(made, "", pose);
    return change.refusal ? 0 : read_camera(applied(made, change)).perspective().field_of_view();
  };
  const auto across = [](double aspect) {
    return portable::degrees(2 * std::atan(std::tan(portable::radians(20)) / aspect));
  };
  EXPECT_NEAR(yfov("vertical", 0), 40, 1e-5);
  EXPECT_NEAR(yfov("smaller", 1.5), 40, 1e-5);
  EXPECT_NEAR(yfov("smaller", .5), across(.5), 1e-5);
  EXPECT_NEAR(yfov("larger", 1.5), across(1.5), 1e-5);
  EXPECT_NEAR(yfov("larger", .5), 40, 1e-5);
  EXPECT_NEAR(yfov("horizontal", .5), across(.5), 1e-5);
  EXPECT_EQ(yfov("smaller", 0), 0) << "refused";
}

TEST(StudioEdit, WritesAnOrthographicGltfCamera) {
  const std::string text = document(
      R"({"camera": 0})",
      R"("cameras": [{"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "zfar": 9, "znear": 0}}])");
  CameraPose pose = kPose;
  const Outline made = gltf_text(text);
  EXPECT_EQ(write_camera(made, "", pose).refusal->found, "a perspective camera");
  pose.orthographic = 5;
  const std::string after = applied(made, write_camera(made, "", pose));
  EXPECT_LT(distance(pose, after), 5e-6);
  EXPECT_EQ(read_camera(after).orthographic().max_y(), 2.5);
  EXPECT_EQ(read_camera(after).orthographic().min_x(), -2.5);
  EXPECT_TRUE(write_camera(gltf_text(after), "", pose).edits.empty());
  EXPECT_EQ(write_camera(gltf_text(document(R"({"camera": 0})")), "", pose).refusal->found,
            "an orthographic camera");
}

}  // namespace
}  // namespace tessera::edit
