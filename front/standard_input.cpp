#include "front/standard_input.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>

#include "base/error.h"

namespace tessera {

namespace fs = std::filesystem;

namespace {

constexpr const char* kName = "stdin";

std::string read_all() {
  constexpr size_t kMostBytes = size_t{1} << 33, kAtOnce = size_t{1} << 18;
  std::string bytes;
  while (true) {
    const size_t size = bytes.size();
    bytes.resize(size + kAtOnce);
    const ssize_t count = ::read(STDIN_FILENO, &bytes[size], kAtOnce);
    bytes.resize(size + static_cast<size_t>(count > 0 ? count : 0));
    if (count == 0) return bytes;
    if (count < 0 && errno != EINTR)
      throw scene_error(fmt::format("{}: {}", kName, std::strerror(errno)));
    if (bytes.size() > kMostBytes)
      throw scene_error(SourcePlace{kName}, "does not end",
                        fmt::format("at most {} bytes", kMostBytes));
  }
}

}  // namespace

void take_standard_input(std::string& scene, ReadOptions& reading) {
  if (scene != "-") return;
  scene = kName;
  reading.text_of = [text = std::make_shared<const std::string>(read_all()),
                     place = fs::weakly_canonical(fs::absolute(kName))](const fs::path& file) {
    return file == place ? text : nullptr;
  };
}

}  // namespace tessera
