#include "studio/files/studio_settings.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/error_of.h"
#include "tests/file_size_limit.h"
#include "tests/temporary_folder.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const json kNothing = json::object();

std::string refusal(const StudioSettings& settings, const json& kept) {
  return error_of([&] { settings.keep(kept); }, ExitCode::render_failed);
}

TEST(StudioSettings, KeepsObjectsForAllAndForEachFolder) {
  const TemporaryFolder folder;
  const StudioSettings settings(folder.path() / "config/tessera");
  EXPECT_EQ(settings.general(), kNothing);
  EXPECT_EQ(settings.of_folder("/scenes"), kNothing);
  settings.keep({{"theme", "dark"}, {"size", 16}});
  settings.keep_of_folder("/scenes", {{"open", {"a.crt"}}});
  settings.keep_of_folder("/others", {{"open", json::array()}});
  EXPECT_EQ(settings.general(), (json{{"theme", "dark"}, {"size", 16}}));
  EXPECT_EQ(settings.of_folder("/scenes"), (json{{"open", {"a.crt"}}}));
  EXPECT_EQ(settings.of_folder("/others"), (json{{"open", json::array()}}));
  EXPECT_TRUE(fs::exists(folder / "config/tessera/studio.json"));
}

TEST(StudioSettings, TheFoldersThatWereOpenedLastAreKnownTheNewestFirst) {
  using Folders = std::vector<std::string>;
  const TemporaryFolder folder;
  const StudioSettings settings(folder.path());
  EXPECT_EQ(settings.recent_folders(), Folders());
  for (const char* const each : {"/a", "/b c", "/a"}) settings.note_opened(each);
  EXPECT_EQ(settings.recent_folders(), (Folders{"/a", "/b c"}));
  for (int i = 0; i < 12; ++i) settings.note_opened("/" + std::to_string(i));
  EXPECT_EQ(settings.recent_folders(),
            (Folders{"/11", "/10", "/9", "/8", "/7", "/6", "/5", "/4", "/3", "/2"}));
  EXPECT_EQ(settings.general(), kNothing);
  std::ofstream(folder / "studio_recent.json") << R"({"folders": [1, "there", "/x", null, "/y"]})";
  EXPECT_EQ(settings.recent_folders(), (Folders{"/x", "/y"}));
  std::ofstream(folder / "studio_recent.json") << R"({"folders": "/x"})";
  EXPECT_EQ(settings.recent_folders(), Folders());
  StudioSettings({}).note_opened("/a");
}

TEST(StudioSettings, WhatWasLeftHalfWrittenIsRemoved) {
  const TemporaryFolder folder;
  const StudioSettings settings(folder.path());
  settings.keep_of_folder("/scenes", kNothing);
  for (const char* const left : {".tessera-1.part", "studio/.tessera-2.part"}) {
    std::ofstream(folder / left) << "{";
  }
  settings.note_opened("/scenes");
  EXPECT_FALSE(fs::exists(folder / ".tessera-1.part"));
  EXPECT_FALSE(fs::exists(folder / "studio/.tessera-2.part"));
}

RC_GTEST_PROP(StudioSettings, AnyTextAndNumberComesBack, ()) {
  const TemporaryFolder folder;
  const StudioSettings settings(folder.path());
  const auto numbers = *rc::gen::arbitrary<std::map<std::string, int64_t>>();
  json kept = json::object();
  for (const auto& [name, number] : numbers) {
    std::string ascii = name;
    for (char& c : ascii) c = static_cast<char>(c & 0x7F);
    kept[ascii] = number;
  }
  settings.keep(kept);
  RC_ASSERT(settings.general() == kept);
}

TEST(StudioSettings, DamagedFilesCountAsNone) {
  const TemporaryFolder folder;
  const StudioSettings settings(folder.path());
  const std::string brackets = std::string(40, '[') + std::string(40, ']');
  const std::vector<std::string> all{
      "",
      "{",
      "[1]",
      "null",
      "{\"a\": 1} x",
      "{\"a\": \"\xFF\"}",
      std::string(200000, '['),
      brackets,
      "{\"a\":" + brackets + "}",
      "{\"a\": \"" + std::string(StudioSettings::kMostBytes, 'x') + "\"}"};
  for (const std::string& damaged : all) {
    std::ofstream(folder / "studio.json", std::ios::binary) << damaged;
    EXPECT_EQ(settings.general(), kNothing) << damaged.substr(0, 50);
  }
  // Brackets in a text are no depth.
  const json text{{"a", std::string(100, '[') + "\\\""}};
  settings.keep(text);
  EXPECT_EQ(settings.general(), text);
  fs::remove(folder / "studio.json");
  mkfifo((folder / "studio.json").c_str(), 0600);
  EXPECT_EQ(settings.general(), kNothing);
}

TEST(StudioSettings, WhatCannotBeKeptChangesNothing) {
  const TemporaryFolder folder;
  const StudioSettings settings(folder.path());
  const json before{{"theme", "dark"}};
  settings.keep(before);
  json deep = json::object();
  for (int i = 0; i < StudioSettings::kMostDepth; ++i) deep = json{{"a", deep}};
  EXPECT_NE(refusal(settings, deep), "no error");
  EXPECT_NE(refusal(settings, json::array()), "no error");
  EXPECT_NE(refusal(settings, {{"a", std::string(StudioSettings::kMostBytes, 'x')}}), "no error");
  {
    const FileSizeLimit limit(1000);
    EXPECT_NE(refusal(settings, {{"a", std::string(5000, 'x')}}), "no error");
  }
  EXPECT_EQ(settings.general(), before);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 1);
}

TEST(StudioSettings, ALinkToThemStays) {
  const TemporaryFolder folder;
  fs::create_directories(folder / "dotfiles");
  std::ofstream(folder / "dotfiles/studio.json") << "{}";
  fs::create_directories(folder / "tessera");
  fs::create_symlink("../dotfiles/studio.json", folder / "tessera/studio.json");
  const StudioSettings settings(folder.path() / "tessera");
  settings.keep({{"a", 1}});
  EXPECT_TRUE(fs::is_symlink(folder / "tessera/studio.json"));
  EXPECT_EQ(settings.general(), (json{{"a", 1}}));
}

TEST(StudioSettings, ThoseOfManyFoldersDoNotPileUp) {
  const TemporaryFolder folder;
  const StudioSettings settings(folder.path());
  for (size_t i = 0; i < StudioSettings::kMostFolders + 3; ++i)
    settings.keep_of_folder("/scenes/" + std::to_string(i), {{"number", i}});
  EXPECT_EQ(std::distance(fs::directory_iterator(folder / "studio"), fs::directory_iterator()),
            static_cast<std::ptrdiff_t>(StudioSettings::kMostFolders));
  EXPECT_EQ(settings.of_folder("/scenes/0"), kNothing);
  EXPECT_EQ(settings.of_folder("/scenes/202"), (json{{"number", 202}}));
}

TEST(StudioSettings, LieWhereTheUserKeepsSettings) {
  ASSERT_EQ(setenv("XDG_CONFIG_HOME", "/config", 1), 0);
  EXPECT_EQ(StudioSettings::default_folder(), "/config/tessera");
  unsetenv("XDG_CONFIG_HOME");
  ASSERT_EQ(setenv("HOME", "/home/somebody", 1), 0);
  EXPECT_EQ(StudioSettings::default_folder(), "/home/somebody/.config/tessera");
  unsetenv("HOME");
  EXPECT_EQ(StudioSettings::default_folder(), "");
  const StudioSettings nowhere{""};
  nowhere.keep({{"a", 1}});
  EXPECT_EQ(nowhere.general(), kNothing);
}

}  // namespace
}  // namespace tessera
