#include "renderer/scene/occluders.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "renderer/scene/scene_builder.h"
#include "tests/unit/renderer/scene_text.h"

namespace tessera {
namespace {

std::shared_ptr<const Scene> scene_with(const std::string& more) {
  std::string text = "nodes { light { point { position { y: 9 } } } } ";
  for (int i = 0; i < 12; ++i)
    text +=
        fmt::format("nodes {{ shape {{ sphere {{ center {{ x: {} }} radius: 1 }} }} }} ", 3 + i);
  v1::FrameSettings frame = frame_of(8, 8);
  frame.set_accelerator("bvh");
  return build_scene(parse_scene(text + more), {}, frame, 1);
}

TEST(Occluders, LightsLookUpWhatIsHeldInBoxes) {
  const auto scene = scene_with("");
  EXPECT_EQ(scene->occluders.buffers.size(), 1u);
  EXPECT_NE(scene->occluders.few, nullptr);
}

// Rectangles are in no box that a light could look up, and throw shadows all the same.
TEST(Occluders, RectanglesAreTraced) {
  const auto scene = scene_with(
      "nodes { shape { rectangle { corner { x: -1 y: 2 z: -1 } edge_u { x: 2 } edge_v { z: 2 } } } "
      "}");
  EXPECT_TRUE(scene->occluders.buffers.empty());
  EXPECT_EQ(scene->occluders.buffers_at({}), nullptr);
  TraversalCounters counters;
  EXPECT_TRUE(scene->occluders.opaque->any_hit({{0, 0, 0}, {0, 9, 0}, 0, 1}, counters));
}

}  // namespace
}  // namespace tessera
