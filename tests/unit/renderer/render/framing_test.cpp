// Cameras that grow their view, billboards, and what lies behind everything.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/renderer/scene_text.h"

namespace tessera {
namespace {

bool is_lit(const TilePixels& tile, int x, int y) {
  return tile.values[static_cast<size_t>(3 * (y * tile.rect.width() + x))] > 0;
}

/// The number of lit pixels, and of those at the frame's edge.
std::pair<int, int> lit(const TilePixels& tile) {
  int all = 0, at_edge = 0;
  const int w = tile.rect.width(), h = tile.rect.height();
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      if (!is_lit(tile, x, y)) continue;
      ++all;
      if (x == 0 || y == 0 || x == w - 1 || y == h - 1) ++at_edge;
    }
  }
  return {all, at_edge};
}

constexpr char kBright[] =
    "materials { name: 'm' unlit {} } nodes { transform { steps { translate { x: 7 y: 2 } } } "
    "shape { materials: 'm' box { min { x: -3 y: -3 z: -3 } max { x: 3 y: 3 z: 3 } } } } ";

TEST(FrameAll, takes_everything_in) {
  for (const char* projection : {"perspective { field_of_view: 30 }", "orthographic {}"}) {
    const std::string camera = std::string("cameras { ") + projection + " %s } ";
    const auto with = [&](const char* more) {
      std::string text = camera;
      text.replace(text.find("%s"), 2, more);
      return render_text(text + kBright, 200, 100);
    };
    EXPECT_EQ(lit(with("")).first, 0) << projection;
    const auto framed = lit(with("frame_all: true"));
    EXPECT_GT(framed.first, 300) << projection;
    EXPECT_EQ(framed.second, 0) << projection;
  }
}

/// The pixels between what is lit and the frame's sides.
struct Margins {
  int left, right, top, bottom;
};

Margins margins(const TilePixels& tile) {
  const int w = tile.rect.width(), h = tile.rect.height();
  Margins out{w, w, h, h};
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      if (!is_lit(tile, x, y)) continue;
      out = {std::min(out.left, x), std::min(out.right, w - 1 - x), std::min(out.top, y),
             std::min(out.bottom, h - 1 - y)};
    }
  }
  return out;
}

TEST(FrameAll, fills_the_frame_in_its_middle) {
  const std::string shapes[] = {"sphere { center { x: 3 y: 1 z: -2 } radius: 5 }",
                                "box { min { x: 1 } max { x: 9 y: 2 z: 3 } }",
                                "cylinder { radius: 3 height: .5 }",
                                "cone { radius: 2 height: 7 top_radius: 1 }",
                                "disc { center { x: 4 } normal { y: 1 z: .3 } radius: 2 }",
                                "rectangle { edge_u { x: 3 y: 1 } edge_v { y: 2 z: -3 } }",
                                "polygon { points { } points { x: 3 y: 1 } points { x: 3 y: 3 z: "
                                "-3 } points { y: 2 z: -3 } }",
                                "torus { major_radius: 4 }"};
  const std::string frames[] = {
      "steps { look_at { eye { x: 30 y: 20 z: 25 } target { x: 8 } } }",  // far away, aside
      "steps { look_at { eye { x: 1 y: .5 z: 1 } target { } } }"};        // in the midst of it
  for (const std::string& shape : shapes) {
    for (const std::string& frame : frames) {
      for (const char* projection : {"perspective { field_of_view: 60 }", "orthographic {}"}) {
        for (const auto& [w, h] : {std::pair{240, 120}, std::pair{120, 240}}) {
          const Margins m = margins(render_text(
              "cameras { frame_all: true " + std::string(projection) + " world_from_camera { " +
                  frame + " } } materials { name: 'm' unlit {} sides: TWO_SIDED } nodes { " +
                  "shape { materials: 'm' " + shape + " } }",
              w, h));
          const std::string which = shape + frame + projection + std::to_string(w);
          EXPECT_NEAR(m.left, m.right, 2) << which;
          EXPECT_NEAR(m.top, m.bottom, 2) << which;
          const int least = std::min(m.left, m.top);
          EXPECT_GE(least, 1) << which;
          EXPECT_LE(least, 5) << which;
        }
      }
    }
  }
}

/// What is near takes more room than what is far, and vertices that no face has take none.
TEST(FrameAll, goes_by_what_is_seen_of_several) {
  const std::string mesh =
      "mesh { inline_positions: [ 0, 0, 0, 2, 0, 0, 0, 6, -9, 100, 100, 100 ] inline_triangles: [ "
      "0, "
      "1, 2 ] }";
  const Margins m = margins(render_text(
      "cameras { frame_all: true } materials { name: 'm' unlit {} sides: TWO_SIDED } nodes { shape "
      "{ materials: 'm' " +
          mesh +
          " } } nodes { transform { steps { translate { x: -3 z: -20 } } } "
          "shape { materials: 'm' sphere { radius: 1 } } }",
      300, 200));
  EXPECT_NEAR(m.left, m.right, 2);
  EXPECT_NEAR(m.top, m.bottom, 2);
  EXPECT_LE(std::min(m.left, m.top), 7);
}

TEST(FrameAll, leaves_a_view_of_nothing) {
  for (const char* projection : {"perspective { }", "orthographic {}"}) {
    EXPECT_EQ(
        lit(render_text(std::string("cameras { frame_all: true ") + projection + " }", 9, 9)).first,
        0);
  }
}

TEST(FrameAll, passes_by_what_never_ends) {
  const auto tile = render_text(std::string("cameras { frame_all: true } nodes { shape { plane { "
                                            "offset: -5 } } } ") +
                                    kBright,
                                200, 200);
  EXPECT_EQ(lit(tile).second, 0);
  EXPECT_GT(lit(tile).first, 0);
}

/// A card that is dark seen from the side, behind turned frames; the viewer is off at +x.
std::string card(const std::string& billboard) {
  return "cameras { world_from_camera { steps { look_at { eye { x: 10 y: 4 } target {} } } } "
         "orthographic { min_x: -2 min_y: -2 max_x: 2 max_y: 2 } } materials { name: 'm' unlit {} "
         "} nodes { transform { steps { rotate { axis { y: 1 } angle: 30 } } steps { scale { x: 2 "
         "y: 2 z: 2 } } } " +
         billboard +
         " children { shape { materials: 'm' rectangle { corner { x: -.5 y: -.5 } edge_u { x: 1 } "
         "edge_v { y: 1 } } } } } ";
}

TEST(Billboards, turn_to_the_viewer) {
  // Unturned it is seen at 60 degrees and 22 degrees from above.
  const int aside = lit(render_text(card(""), 80, 80)).first;
  const int upright = lit(render_text(card("billboard_axis { y: 1 }"), 80, 80)).first;
  const int facing = lit(render_text(card("billboard_axis {}"), 80, 80)).first;
  EXPECT_NEAR(aside, 1600 * .5 * .928, 60);
  EXPECT_NEAR(upright, 1600 * .928, 60);
  EXPECT_EQ(facing, 1600);
}

TEST(Billboards, without_an_axis_are_parallel_to_the_picture) {
  // Far off the view's middle, in frames that turn, mirror and stretch: an upright rectangle.
  for (const char* frame : {"x: 2 y: 2 z: 2", "x: -2 y: 2 z: 2", "x: 2 y: 2 z: 1"}) {
    const auto tile = render_text(
        std::string("cameras { world_from_camera { steps { translate { z: 6 } } } perspective { "
                    "field_of_view: 90 } } materials { name: 'm' unlit {} } nodes { transform { "
                    "steps { translate { x: 2.5 y: 2 } } steps { scale { ") +
            frame +
            " } } steps { rotate { axis { y: 1 } angle: 50 } } } billboard_axis {} children { "
            "shape { materials: 'm' rectangle { corner { x: -.5 y: -.5 } edge_u { x: 1 } edge_v "
            "{ y: 1 } } } } }",
        120, 120);
    int left = 120, right = -1, top = 120, bottom = -1;
    for (int y = 0; y < 120; ++y) {
      for (int x = 0; x < 120; ++x) {
        if (!is_lit(tile, x, y)) continue;
        left = std::min(left, x), right = std::max(right, x);
        top = std::min(top, y), bottom = std::max(bottom, y);
      }
    }
    EXPECT_EQ(bottom - top + 1, 20) << frame;
    EXPECT_EQ(lit(tile).first, (right - left + 1) * (bottom - top + 1)) << frame;
  }
}

TEST(Billboards, keep_their_place_with_the_viewer_on_the_axis) {
  const auto tile = render_text(
      "cameras { world_from_camera { steps { translate { z: 10 } } } } materials { name: 'm' unlit "
      "{} } nodes { billboard_axis { z: 1 } shape { materials: 'm' box {} } }",
      9, 9);
  EXPECT_TRUE(is_lit(tile, 4, 4));
}

/// The cube's pictures are one texel each: the face's number over 255.
v1::Scene cube_scene(BlobStore& blobs, const std::string& camera) {
  std::string text = "background { solid { r: 1 } cube {";
  const char* faces[] = {"front", "back", "left", "right", "top"};  // and no bottom
  std::string textures;
  for (int i = 0; i < 5; ++i) {
    const std::string name = faces[i];
    const std::string digest =
        blobs.put({static_cast<std::byte>(10 * (i + 1)), static_cast<std::byte>(255)}).hex();
    text += " " + name + ": '" + name + "'";
    textures += "textures { name: '" + name + "' image { texels { digest: '" + digest +
                "' } width: 1 height: 1 channels: 2 bits: 8 encoding: ENCODING_LINEAR } } ";
  }
  return parse_scene(text + " } } " + textures + camera);
}

TEST(Background, a_cube_has_its_faces_where_they_belong) {
  const std::pair<const char*, int> looks[] = {{"z: -1", 10}, {"z: 1", 20}, {"x: -1", 30},
                                               {"x: 1", 40},  {"y: 1", 50}, {"y: -1", 255}};
  for (const auto& [target, expected] : looks) {
    BlobStore blobs;
    const v1::Scene scene =
        cube_scene(blobs, std::string("cameras { world_from_camera { steps { look_at { target { ") +
                              target + " } } } } }");
    const auto renderer = make_tile_renderer(scene, blobs, frame_of(1, 1), 1);
    EXPECT_FLOAT_EQ(render_rect(*renderer, {0, 0, 1, 1}).values[0],
                    static_cast<float>(expected) / 255)
        << target;
  }
}

TEST(Background, a_cube_picture_stands_upright) {
  // Top row dark, bottom row bright, on the front; the camera sees the middle of it.
  BlobStore blobs;
  const std::string digest = blobs.put({std::byte{0}, std::byte{255}}).hex();
  const auto tile = render_text(
      "background { cube { front: 't' } } textures { name: 't' image { texels { digest: '" +
          digest +
          "' } width: 1 height: 2 channels: 1 bits: 8 encoding: ENCODING_LINEAR filter: NEAREST } "
          "}",
      1, 4, blobs);
  EXPECT_EQ(tile.values[3], 0);
  EXPECT_EQ(tile.values[6], 1);
}

TEST(Background, may_be_half_there) {
  EXPECT_EQ(render_pixel("background { solid { r: 1 g: .5 } transparency: .5 }"),
            (std::vector<float>{.5f, .25f, 0}));
}

}  // namespace
}  // namespace tessera
