// A scene file of our own in each of its forms: refused with an Error, or kept without loss through
// every form, and rendered. The first byte chooses the form, so that one corpus serves all three.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string_view>

#include "base/error.h"
#include "proto/wire/scene_codec.h"
#include "tests/fuzz/render_fuzzed.h"

namespace {

using tessera::SceneEncoding;
constexpr SceneEncoding kEncodings[] = {SceneEncoding::text, SceneEncoding::binary,
                                        SceneEncoding::json};

std::optional<tessera::SceneWithBlobs> read(std::string_view bytes, SceneEncoding encoding) {
  try {
    return tessera::decode_scene(bytes, encoding, "fuzz");
  } catch (const tessera::Error&) {
    return std::nullopt;  // how a wrong file is refused
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  const auto first = read(bytes, kEncodings[data[0] % 3]);
  if (!first) return 0;
  const std::string before = tessera::serialize_scene(first->scene);
  for (const SceneEncoding encoding : kEncodings) {
    const auto again = read(tessera::encode_scene(first->scene, first->blobs, encoding), encoding);
    if (!again || tessera::serialize_scene(again->scene) != before) std::abort();
  }
  tessera::render_fuzzed(first->scene, first->blobs);
  return 0;
}
