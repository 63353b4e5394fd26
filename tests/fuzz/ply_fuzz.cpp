// Whatever the bytes, the PLY reader gives a scene or an Error, and the scene a picture.

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "base/error.h"
#include "scenes/formats/ply/ply_reader.h"
#include "tests/fuzz/render_fuzzed.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  try {
    const tessera::LoadedScene loaded =
        tessera::parse_ply({reinterpret_cast<const char*>(data), size}, "fuzz.ply");
    tessera::render_fuzzed(loaded.scene, loaded.blobs);
  } catch (const tessera::Error&) {
  }
  return 0;
}
