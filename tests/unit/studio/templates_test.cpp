#include "studio/files/templates.h"

#include <gtest/gtest.h>

#include <string>

#include "base/file.h"
#include "scenes/formats/read_scene.h"
#include "studio/files/document.h"
#include "studio/files/folder.h"
#include "tests/temporary_folder.h"

namespace tessera {
namespace {

TEST(StudioTemplates, AreScenesWithoutWarnings) {
  for (const SceneTemplate& scene : scene_templates()) {
    const TemporaryFolder root;
    const Folder folder(root.path());
    for (const TemplateFile& file : scene.files) {
      folder.create(file.name, file.text);
      EXPECT_EQ(Document(file.text).line_ends(), "lf");
    }
    const LoadedScene loaded = read_scene(root / scene.files.front().name);
    EXPECT_TRUE(loaded.warnings.empty()) << scene.id;
    EXPECT_TRUE(loaded.unused.empty()) << scene.id;
    EXPECT_EQ(loaded.scene.cameras_size(), 1) << scene.id;
  }
}

TEST(StudioTemplates, LuxHasItsDefaultsAndASphereOf80Triangles) {
  const SceneTemplate& lux = scene_templates().at(1);
  ASSERT_EQ(lux.id, "lux");
  ASSERT_EQ(lux.files.at(1).name, "sphere.obj");
  const TemporaryFolder root;
  for (const TemplateFile& file : lux.files) write_output_file(root / file.name, file.text);
  const v1::Scene scene = read_scene(root / "lux.tessera").scene;
  EXPECT_EQ(scene.settings().width(), 1600u);
  EXPECT_EQ(scene.settings().height(), 900u);
  EXPECT_EQ(scene.settings().output().tone_map(), v1::Output::REINHARD);
  EXPECT_EQ(scene.cameras(0).perspective().field_of_view(), 25);
  EXPECT_EQ(scene.cameras(0).perspective().axis(), v1::Perspective::VERTICAL);
  size_t triangles = 0;
  for (const auto& object : scene.objects()) {
    for (const auto& node : object.nodes())
      triangles += node.shape().mesh().triangles().size() / 12;
  }
  EXPECT_EQ(triangles, 80u);
}

}  // namespace
}  // namespace tessera
