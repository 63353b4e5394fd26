#include "front/load_frame.h"

#include "front/texture_decoder.h"
#include "scenes/formats/read_scene.h"

namespace tessera {

LoadedScene load_frame(const RenderOptions& options, int frame) {
  ReadOptions reading = options.reading;
  reading.decode_texture = decode_texture;
  reading.decode_texture_bytes = decode_texture_bytes;
  reading.frame = frame;
  LoadedScene loaded = read_scene(options.scene, reading);
  for (v1::Camera& camera : *loaded.scene.mutable_cameras()) {
    if (options.pinhole) camera.clear_lens();
    if (options.frame_all) camera.set_frame_all(true);
  }
  return loaded;
}

}  // namespace tessera
