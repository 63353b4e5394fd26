#include "base/program_folder.h"

#include <system_error>

namespace tessera {
namespace {

std::string& path_of_program() {
  static std::string path = "/proc/self/exe";
  return path;
}

}  // namespace

std::string program_path() { return path_of_program(); }

std::filesystem::path program_folder() {
  const std::filesystem::path program = program_path();
  std::error_code is_no_link;
  const auto target = std::filesystem::read_symlink(program, is_no_link);
  return (is_no_link ? program : target).parent_path();
}

void set_program(const std::filesystem::path& program) {
  path_of_program() = std::filesystem::weakly_canonical(program).string();
}

}  // namespace tessera
