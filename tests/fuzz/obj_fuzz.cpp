// Whatever the bytes, the OBJ reader gives a scene or an Error.

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "base/error.h"
#include "scenes/formats/obj/obj_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  try {
    tessera::parse_obj({reinterpret_cast<const char*>(data), size}, "fuzz.obj");
  } catch (const tessera::Error&) {
  }
  return 0;
}
