#include <gtest/gtest.h>

#include "base/error.h"
#include "renderer/scene/scene_builder.h"
#include "tests/error_of.h"
#include "tests/unit/renderer/scene_text.h"

namespace tessera {
namespace {

const std::string kLook = R"(
  cameras { orthographic { min_x: -2 min_y: -2 max_x: 2 max_y: 2 }
            world_from_camera { steps { translate { z: 10 } } } }
  materials { name: 'a' unlit { color { value { r: 1 g: 0 b: 0 } } } }
  materials { name: 'b' unlit { color { value { r: 0 g: 1 b: 0 } } } }
  materials { name: 'c' unlit { color { value { r: 0 g: 0 b: 1 } } } }
)";

std::string ball(const std::string& material, double radius) {
  return "shape { materials: '" + material + "' sphere { radius: " + std::to_string(radius) +
         " } }";
}

std::string csg(const std::string& operation, const std::vector<std::string>& operands) {
  std::string text = "shape { csg { operation: " + operation;
  for (const std::string& operand : operands) text += " operands { " + operand + " }";
  return text + " } }";
}

/// 'a', 'b' or 'c' by the colour in the middle of the picture; '.' for black.
char middle(const std::string& nodes) {
  const std::vector<float> v = render_text(kLook + nodes, 3, 3).values;
  const size_t at = 3 * 4;
  return v[at] > 0 ? 'a' : v[at + 1] > 0 ? 'b' : v[at + 2] > 0 ? 'c' : '.';
}

char middle_of(const std::string& shape) { return middle("nodes { " + shape + " }"); }

std::string moved(const std::string& shape, double z) {
  return "transform { steps { translate { z: " + std::to_string(z) + " } } } " + shape;
}

TEST(CsgScene, shows_the_material_of_the_surface_that_is_seen) {
  EXPECT_EQ(middle_of(csg("UNION", {ball("a", .5), ball("b", 1)})), 'b');
  EXPECT_EQ(middle_of(csg("INTERSECTION", {ball("a", .5), ball("b", 1)})), 'a');
  // Carved from the front: the hole has the material of what carved it.
  EXPECT_EQ(middle_of(csg("DIFFERENCE", {ball("a", 1), moved(ball("b", .5), 1)})), 'b');
  EXPECT_EQ(middle_of(csg("DIFFERENCE", {ball("a", 1), ball("b", 2)})), '.');
}

TEST(CsgScene, places_operands_nested_and_moved) {
  const std::string inner =
      csg("INTERSECTION", {moved(ball("a", 1), -3), moved(ball("b", .5), -3)});
  EXPECT_EQ(middle_of(csg("UNION", {inner, moved(ball("c", 1), -6)})), 'b');
  EXPECT_EQ(middle_of(csg("UNION", {moved(inner, -6), moved(ball("c", 1), -6)})), 'c');
}

TEST(CsgScene, an_operand_is_the_union_of_what_is_below_it) {
  const std::string two =
      "children { " + moved(ball("a", .4), 1) + " } children { " + moved(ball("b", .4), 1.5) + " }";
  EXPECT_EQ(middle_of(csg("INTERSECTION", {two, ball("c", 3)})), 'b');
  EXPECT_EQ(middle("objects { name: 'o' nodes { " + ball("b", 1) + " } } nodes { " +
                   csg("DIFFERENCE", {ball("a", 2),
                                      "instance_of: 'o' transform { steps { "
                                      "translate { z: 2 } } }"}) +
                   " }"),
            'b');
}

TEST(CsgScene, what_is_hidden_or_flat_is_not_there) {
  EXPECT_EQ(middle_of(csg("UNION", {"hidden: true " + ball("a", 2), ball("b", 1)})), 'b');
  EXPECT_EQ(middle_of(csg("DIFFERENCE", {ball("a", 1), "hidden: true " + ball("b", 2)})), 'a');
  EXPECT_EQ(middle_of(csg("DIFFERENCE", {"hidden: true " + ball("a", 1), ball("b", 2)})), '.');
  EXPECT_EQ(middle_of(csg("INTERSECTION", {ball("a", 1), "hidden: true " + ball("b", 2)})), '.');
  EXPECT_EQ(middle_of(csg("UNION", {})), '.');
}

std::string csg_complaint(const std::string& nodes) {
  return error_of([&] { build_scene(parse_scene(kLook + nodes), {}, frame_of(3, 3), 1); });
}

TEST(CsgScene, lets_through_what_the_vertices_of_its_parts_do) {
  std::vector<float> colors;
  for (int i = 0; i < 4; ++i) colors.insert(colors.end(), {1, 0, 0, .25f});
  const auto* const bytes = reinterpret_cast<const std::byte*>(colors.data());
  BlobStore blobs;
  const size_t size = colors.size() * sizeof(float);
  const std::string digest = blobs.put(std::vector<std::byte>(bytes, bytes + size)).hex();
  const std::string mesh =
      "shape { materials: 'white' mesh { closed: true inline_triangles: [0,2,1, 0,1,3, 0,3,2, "
      "1,2,3] "
      "inline_positions: [-9,-9,1, 9,-9,1, 0,9,1, 0,0,-1] colors { digest: '" +
      digest + "' size: " + std::to_string(size) + " } } }";
  const std::string before =
      "background { solid { b: 1 } } materials { name: 'white' unlit {} } nodes { ";
  const auto seen = [&](const std::string& node) {
    return render_text(before + node + " }", 1, 1, blobs).values;
  };
  const std::vector<float> twice{.4375f, 0, .5625f};
  EXPECT_EQ(seen(mesh), twice);
  EXPECT_EQ(seen(csg("UNION", {mesh})), twice);
}

TEST(CsgScene, refuses_what_has_no_inside) {
  EXPECT_NE(
      csg_complaint("nodes { " + csg("UNION", {ball("a", 1), "name: 'd' shape { disc {} }"}) + " }")
          .find("operand 'd': a CSG operand is a surface without an inside"),
      std::string::npos);
  EXPECT_NE(csg_complaint("nodes { " + csg("UNION", {"instance_of: 'x'"}) + " }").find("'x'"),
            std::string::npos);
  const std::string loop = csg("UNION", {"instance_of: 'o'"});
  EXPECT_NE(csg_complaint("objects { name: 'o' nodes { " + loop + " } } nodes { " + loop + " }")
                .find("without a cycle"),
            std::string::npos);
}

TEST(SignedDiffuse, a_plane_shades_itself_from_light_behind_it) {
  const std::string scene = R"(
    cameras { orthographic {} world_from_camera { steps { translate { z: 5 } } } }
    materials { name: 'm' sides: FRONT_ONLY classic { diffuse_model: SIGNED
                diffuse { value { r: 1 g: 1 b: 1 } } } }
    nodes { shape { materials: 'm' plane { normal { z: 1 } } } }
    nodes { light { point { position { z: -3 } } } })";
  EXPECT_EQ(render_pixel(scene)[0], 0);
  EXPECT_LT(render_pixel(scene + "settings { integrator { shadows: SHADOWS_OFF } }")[0], 0);
}

TEST(LensInScene, spreads_what_is_out_of_focus) {
  const auto lit = [](const std::string& lens) {
    const TilePixels tile = render_text(R"(
      cameras { perspective { field_of_view: 40 } )" +
                                            lens + R"( }
      materials { name: 'a' unlit {} }
      nodes { shape { materials: 'a' sphere { center { z: -5 } radius: .5 } } })",
                                        31, 31);
    int touched = 0;
    double sum = 0;
    for (size_t i = 0; i < tile.values.size(); i += 3) {
      touched += tile.values[i] > 0;
      sum += tile.values[i];
    }
    return std::pair(touched, sum);
  };
  const auto sharp = lit("");
  const auto blurred = lit("lens { radius_x: .3 radius_y: .3 focal_distance: 20 samples: 256 }");
  EXPECT_GT(blurred.first, sharp.first * 3 / 2);
  EXPECT_NEAR(blurred.second / sharp.second, 1, 0.1);
  const auto focused = lit("lens { radius_x: .3 radius_y: .3 focal_distance: 5 samples: 256 }");
  EXPECT_LT(focused.first, sharp.first * 5 / 4);
}

TEST(CornerGrid, one_sample_lies_in_the_pixels_centre) {
  const std::string scene = R"(
    settings { sampling { samples_per_pixel: 1 pattern: CORNER_GRID } }
    cameras { orthographic {} world_from_camera { steps { translate { z: 5 } } } }
    materials { name: 'a' unlit {} } nodes { shape { materials: 'a' sphere { radius: .1 } } })";
  EXPECT_EQ(render_pixel(scene)[0], 1);
}

}  // namespace
}  // namespace tessera
