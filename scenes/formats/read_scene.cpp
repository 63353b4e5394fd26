#include "scenes/formats/read_scene.h"

#include "proto/wire/scene_codec.h"

namespace tessera {

LoadedScene read_scene(const std::string& path, const ReadOptions&) {
  SceneWithBlobs read =
      read_scene_file(path, scene_encoding_of(path).value_or(SceneEncoding::text));
  return {std::move(read.scene), std::move(read.blobs), {}};
}

std::vector<std::string> readable_endings() {
  return {".tessera", ".tesserab", ".json"};
}

}  // namespace tessera
