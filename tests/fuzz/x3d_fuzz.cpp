// Whatever the bytes, the X3D reader gives a scene or an Error.

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "base/error.h"
#include "scenes/formats/x3d/x3d_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  try {
    tessera::parse_x3d({reinterpret_cast<const char*>(data), size}, "fuzz.x3d", {});
  } catch (const tessera::Error&) {
  }
  return 0;
}
