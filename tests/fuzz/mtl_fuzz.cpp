// Whatever the bytes, the MTL reader gives materials or an Error.

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "base/error.h"
#include "scenes/formats/obj/mtl_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace tessera;
  try {
    LineReader reader(std::string_view(reinterpret_cast<const char*>(data), size), "fuzz.mtl");
    MtlLibrary library;
    Warnings warnings;
    read_mtl(reader, {}, library, warnings);
  } catch (const Error&) {
  }
  return 0;
}
