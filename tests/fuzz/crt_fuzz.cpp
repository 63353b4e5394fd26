// A CRT script: refused with an Error, or a scene that survives its text form and gives a
// picture.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "base/error.h"
#include "base/file.h"
#include "proto/wire/scene_codec.h"
#include "scenes/formats/crt/crt_reader.h"
#include "tests/fuzz/render_fuzzed.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace tessera;
  const std::string text = to_utf8({reinterpret_cast<const char*>(data), size});
  LoadedScene loaded;
  try {
    loaded = parse_crt(text, "fuzz.crt", {}, static_cast<int32_t>(size % 3));
  } catch (const Error&) {
    return 0;  // how a wrong script is refused
  }
  const std::string form = encode_scene(loaded.scene, loaded.blobs, SceneEncoding::text);
  const SceneWithBlobs again = decode_scene(form, SceneEncoding::text, "again");
  if (serialize_scene(again.scene) != serialize_scene(loaded.scene)) std::abort();
  render_fuzzed(loaded.scene, loaded.blobs);
  return 0;
}
