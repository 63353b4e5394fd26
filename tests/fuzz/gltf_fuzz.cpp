// Whatever the bytes, the glTF reader gives a scene or an Error, and the scene a picture. A text
// gets a binary part too, so that accessors have something to read.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "base/error.h"
#include "scenes/formats/gltf/gltf_reader.h"
#include "tests/fuzz/render_fuzzed.h"

namespace {

std::string with_binary_part(std::string_view json) {
  std::string bytes = "glTF";
  const auto word = [&](uint32_t value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  };
  constexpr uint32_t kBinary = 256;
  const auto length = static_cast<uint32_t>(json.size());
  word(2);
  word(12 + 8 + length + 8 + kBinary);
  word(length);
  word(0x4E4F534A);
  bytes += json;
  word(kBinary);
  word(0x004E4942);
  for (uint32_t i = 0; i < kBinary; ++i) bytes += static_cast<char>(i % 5 == 0 ? 0 : i % 64);
  return bytes;
}

void read(std::string_view bytes) {
  try {
    const tessera::LoadedScene loaded = tessera::parse_gltf(bytes, "fuzz.gltf");
    tessera::render_fuzzed(loaded.scene, loaded.blobs);
  } catch (const tessera::Error&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  read(bytes);
  if (bytes.starts_with("{")) read(with_binary_part(bytes));
  return 0;
}
