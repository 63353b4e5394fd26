#include "coordinator/jobs/packed_scene.h"

#include <span>
#include <string>
#include <utility>

#include "job/scene_motion.h"
#include "proto/wire/scene_codec.h"

namespace tessera {

std::optional<SceneFacts> facts_of(const v1::Scene& scene) {
  auto blobs = referenced_blobs(scene);
  if (!blobs) return std::nullopt;
  return SceneFacts{std::move(*blobs), moves(scene)};
}

PackedScene pack_scene(const v1::Scene& scene) {
  const std::string text = serialize_scene(scene);
  const auto bytes = std::as_bytes(std::span(text));
  return {make_blob({bytes.begin(), bytes.end()}), Digest::of(bytes), moves(scene)};
}

}  // namespace tessera
