#include "front/check_buildable.h"

#include "base/process.h"
#include "front/located.h"
#include "front/output_settings.h"
#include "renderer/scene/scene_builder.h"

namespace tessera {

std::shared_ptr<const Scene> check_buildable(const RenderOptions& options,
                                             const LoadedScene& loaded) {
  output_settings(options.scene, loaded.scene.settings().output());
  const v1::FrameSettings settings = frame_settings(options, loaded.scene, std::nullopt);
  try {
    return build_scene(loaded.scene, loaded.blobs, settings, core_count());
  } catch (const Error& error) {
    if (error.code() != ExitCode::bad_scene) throw;
    throw located(options.scene, error.what());
  }
}

}  // namespace tessera
