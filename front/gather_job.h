#pragma once

#include <functional>
#include <string>

#include "client/submitted_job.h"
#include "front/render_options.h"
#include "scenes/import/loaded_scene.h"

namespace tessera {

/// What a job is called and how it stands among others.
struct JobOrder {
  std::string name{};  ///< empty: the scene's
  int priority = 0;    ///< from -kMostPriority to kMostPriority
  int weight = 1;      ///< its share of the workers among jobs of its priority
};

/// All frames that the options ask for as one job of a farm. `load` gives the scene of a frame, and
/// is called again where that depends on the frame; `warn` is told each warning once. Throws
/// usage_error and scene_error for what a render would throw them for, and at once for more than
/// kMostJobFrames frames.
SubmittedJob gather_job(const RenderOptions& options, const JobOrder& order,
                        const std::function<LoadedScene(int frame)>& load,
                        const std::function<void(const std::string&)>& warn);

}  // namespace tessera
