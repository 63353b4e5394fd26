#include "front/load_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "base/error.h"
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

/// What is wrong in a later frame alone tells which.
LoadedScene read_frame(const RenderOptions& options, int frame) {
  try {
    return read_scene(options.scene, reading_of(options, frame));
  } catch (const Error& error) {
    if (!options.frames || frame == options.frames->front()) throw;
    std::string message = error.what();  // below its first line is the text that it is about
    message.insert(std::min(message.find('\n'), message.size()),
                   fmt::format(" (in frame {})", frame));
    throw Error(error.code(), message, error.diagnostics());
  }
}

}  // namespace

LoadedScene load_frame(const RenderOptions& options, int frame) {
  check_view(options);
  LoadedScene loaded = read_frame(options, frame);
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
