// Whatever follows the header of X3D's classic encoding, its reader gives a scene or an Error.

#include <cstddef>
#include <cstdint>
#include <string>

#include "base/error.h"
#include "scenes/formats/x3d/x3d_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  std::string text = "#X3D V4.0 utf8\n";
  text.append(reinterpret_cast<const char*>(data), size);
  try {
    tessera::parse_x3d(text, "fuzz.x3dv", {});
  } catch (const tessera::Error&) {
  }
  return 0;
}
