// Whatever follows the header of VRML97, its reader gives a scene or an Error.

#include <cstddef>
#include <cstdint>
#include <string>

#include "base/error.h"
#include "scenes/formats/x3d/x3d_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  std::string text = "#VRML V2.0 utf8\n";
  text.append(reinterpret_cast<const char*>(data), size);
  try {
    tessera::parse_x3d(text, "fuzz.wrl", {});
  } catch (const tessera::Error&) {
  }
  return 0;
}
