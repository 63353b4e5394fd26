#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "scenes/formats/read_scene.h"
#include "tests/unit/scenes/scene_testing.h"

namespace tessera::testing {

namespace fs = std::filesystem;

/// A folder for the files of a scene, and the one that it lies in.
class ReadScene : public ::testing::Test {
 protected:
  ReadScene() {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    outside_ = fs::path(::testing::TempDir()) / (std::string("tessera_read_scene_") + test->name());
    fs::remove_all(outside_);
    folder_ = outside_ / "scene";
    fs::create_directories(folder_);
  }
  ~ReadScene() override { fs::remove_all(outside_); }

  std::string write(const std::string& name, const std::string& text) {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return (folder_ / name).string();
  }
  std::string error(const std::string& path) {
    std::string message = error_of([&] { read_scene(path); });
    for (size_t at; (at = message.find(folder_.string() + "/")) != std::string::npos;)
      message.erase(at, folder_.string().size() + 1);
    return message;
  }

  static constexpr const char* kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  fs::path outside_, folder_;
};

}  // namespace tessera::testing
