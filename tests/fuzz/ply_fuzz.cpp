// Whatever the bytes, the PLY reader gives a scene or an Error.

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "base/error.h"
#include "scenes/formats/ply/ply_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  try {
    tessera::parse_ply({reinterpret_cast<const char*>(data), size}, "fuzz.ply");
  } catch (const tessera::Error&) {
  }
  return 0;
}
