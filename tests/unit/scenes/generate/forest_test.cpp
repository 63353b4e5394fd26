// A forest's trees are described, sent and built once, however many there are.
#include <gtest/gtest.h>

#include <set>

#include "renderer/scene/scene_builder.h"
#include "scenes/generate/generate_forest.h"

namespace tessera {
namespace {

v1::FrameSettings small_frame() {
  v1::FrameSettings frame;
  frame.set_width(8);
  frame.set_height(8);
  return frame;
}

TEST(Forest, SharesItsTrees) {
  for (const uint32_t trees : {40u, 400u}) {
    const LoadedScene loaded = forest(trees);
    const auto scene = build_scene(loaded.scene, loaded.blobs, small_frame(), 1);
    ASSERT_EQ(scene->instances.size(), trees + 1);
    std::set<const Shape*> shapes;
    size_t shown = 0, kept = 0;
    for (const Instance& instance : scene->instances) {
      shown += instance.shape->primitive_count();
      if (shapes.insert(instance.shape.get()).second) kept += instance.shape->primitive_count();
    }
    EXPECT_EQ(shown, size_t{trees} * kTreeTriangles + 1);
    EXPECT_EQ(kept, 2 * size_t{kTreeTriangles} + 1);
    EXPECT_EQ(shapes.size(), 3u);
    // Positions, triangles and materials of two trees.
    EXPECT_LE(loaded.blobs.size(), 6u);
  }
}

}  // namespace
}  // namespace tessera
