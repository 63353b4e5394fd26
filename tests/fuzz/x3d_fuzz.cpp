// Whatever the bytes, the X3D reader gives a scene or an Error, and the scene a picture.

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "base/error.h"
#include "scenes/formats/x3d/x3d_reader.h"
#include "tests/fuzz/render_fuzzed.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  try {
    const tessera::LoadedScene loaded =
        tessera::parse_x3d({reinterpret_cast<const char*>(data), size}, "fuzz.x3d", {});
    tessera::render_fuzzed(loaded.scene, loaded.blobs);
  } catch (const tessera::Error&) {
  }
  return 0;
}
