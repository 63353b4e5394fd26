#include "front/load_frame.h"

#include "front/scene_view.h"
#include "front/texture_decoder.h"
#include "scenes/formats/read_scene.h"

namespace tessera {

namespace {

ReadOptions reading_of(const RenderOptions& options, int frame) {
  ReadOptions reading = options.reading;
  reading.decode_texture = decode_texture;
  reading.decode_texture_bytes = decode_texture_bytes;
  reading.frame = frame;
  reading.brings_camera = brings_camera(options);
  return reading;
}

}  // namespace

LoadedScene load_frame(const RenderOptions& options, int frame) {
  check_view(options);
  LoadedScene loaded = read_scene(options.scene, reading_of(options, frame));
  apply_scene_options(options, loaded.scene);
  use_view(options, loaded);
  return loaded;
}

LoadedScene load_frame(const RenderOptions& options, const SceneWithBlobs& made, int frame) {
  check_view(options);
  LoadedScene loaded;
  loaded.scene = made.scene;
  loaded.blobs = made.blobs;
  add_files(loaded, options.scene, reading_of(options, frame));
  apply_scene_options(options, loaded.scene);
  use_view(options, loaded);
  return loaded;
}

void apply_scene_options(const RenderOptions& options, v1::Scene& scene) {
  for (v1::Camera& camera : *scene.mutable_cameras()) {
    if (options.pinhole) camera.clear_lens();
    if (options.frame_all) camera.set_frame_all(true);
  }
  // Where neither is given the message stays absent, as it is then in the scene's digest.
  const auto integrator = [&scene] { return scene.mutable_settings()->mutable_integrator(); };
  if (options.max_depth) integrator()->set_max_depth(*options.max_depth);
  if (options.shadows) integrator()->set_shadows(*options.shadows);
}

}  // namespace tessera
