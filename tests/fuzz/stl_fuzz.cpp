// Whatever the bytes, the STL reader gives a scene or an Error.

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "base/error.h"
#include "scenes/formats/stl/stl_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  try {
    tessera::parse_stl({reinterpret_cast<const char*>(data), size}, "fuzz.stl");
  } catch (const tessera::Error&) {
  }
  return 0;
}
