// Whatever the bytes, the OBJ reader gives a scene or an Error, and the scene a picture.

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "base/error.h"
#include "scenes/formats/obj/obj_reader.h"
#include "tests/fuzz/render_fuzzed.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  try {
    const tessera::LoadedScene loaded =
        tessera::parse_obj({reinterpret_cast<const char*>(data), size}, "fuzz.obj");
    tessera::render_fuzzed(loaded.scene, loaded.blobs);
  } catch (const tessera::Error&) {
  }
  return 0;
}
