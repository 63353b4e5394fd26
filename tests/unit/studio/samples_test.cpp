#include "studio/files/samples.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "base/error.h"
#include "base/file.h"
#include "base/program_folder.h"
#include "tests/error_of.h"
#include "tests/temporary_folder.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> names_of(const std::vector<TemplateFile>& files) {
  std::vector<std::string> names;
  for (const TemplateFile& file : files) names.push_back(file.name);
  return names;
}

TEST(StudioSamples, AreBesideAProgramThatIsInstalledOrBuilt) {
  const TemporaryFolder root;
  EXPECT_EQ(Samples::folder_beside(root / "lib/tessera"), "");
  fs::create_directories(root / "lib/tessera");
  fs::create_directories(root / "bin");
  fs::create_directories(root / "share/tessera/samples");
  const fs::path samples = fs::canonical(root / "share/tessera/samples");
  EXPECT_EQ(Samples::folder_beside(root / "lib/tessera"), samples);
  EXPECT_EQ(Samples::folder_beside(root / "bin"), samples);
  EXPECT_TRUE(Samples({}).names().empty());
}

TEST(StudioSamples, OfTheBuildAreThere) {
  const Samples samples(Samples::folder_beside(program_folder()));
  EXPECT_GE(samples.names().size(), 20u);
  EXPECT_TRUE(samples.has("knot.tessera"));
  EXPECT_FALSE(samples.has("hall.png"));
  EXPECT_EQ(names_of(samples.files_of("knot.tessera")), std::vector<std::string>{"knot.tessera"});
  EXPECT_EQ(names_of(samples.files_of("gate.crt")),
            (std::vector<std::string>{"gate.crt", "pawn.obj", "pawn.mtl"}));
}

TEST(StudioSamples, ComeWithWhatTheyNameAndWhatThatNames) {
  const TemporaryFolder root;
  write_output_file(root / "a.tessera", "includes { file: \"b.obj\" } # twice: b.obj");
  write_output_file(root / "b.obj", "mtllib c.mtl\n");
  write_output_file(root / "c.mtl", "map_Kd d.png # of b.obj\n");
  write_output_file(root / "d.png", "png");
  write_output_file(root / "e.png", "png");
  const Samples samples(root.path());
  EXPECT_EQ(samples.names(), std::vector<std::string>{"a.tessera"});
  EXPECT_EQ(names_of(samples.files_of("a.tessera")),
            (std::vector<std::string>{"a.tessera", "b.obj", "c.mtl", "d.png"}));
  EXPECT_EQ(error_of([&] { samples.files_of("../a.tessera"); }), "'../a.tessera' is no sample");
  EXPECT_EQ(error_of([&] { samples.files_of("e.png"); }), "'e.png' is no sample");
}

}  // namespace
}  // namespace tessera
