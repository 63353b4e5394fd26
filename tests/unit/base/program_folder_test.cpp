#include "base/program_folder.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <fstream>
#include <string>

namespace tessera {
namespace {

namespace fs = std::filesystem;

TEST(ProgramFolder, IsThatOfTheRunningProgramUnlessAnotherIsNamed) {
  const fs::path running = fs::read_symlink("/proc/self/exe");
  EXPECT_EQ(program_folder(), running.parent_path());

  std::string made = (fs::temp_directory_path() / "tessera-program-XXXXXX").string();
  ASSERT_NE(mkdtemp(made.data()), nullptr);
  const fs::path folder = fs::canonical(made);
  fs::create_directories(folder / "lib");
  std::ofstream(folder / "lib/program").put('x');
  fs::create_symlink("lib/program", folder / "link");

  // A link stands beside nothing: the folder is that of the file that it leads to.
  set_program(folder / "link");
  EXPECT_EQ(program_path(), (folder / "lib/program").string());
  EXPECT_EQ(program_folder(), folder / "lib");
  // Of a program that is not there, the folder where it should be.
  set_program(folder / "none/program");
  EXPECT_EQ(program_folder(), folder / "none");

  set_program(running);
  EXPECT_EQ(program_folder(), running.parent_path());
  fs::remove_all(folder);
}

}  // namespace
}  // namespace tessera
