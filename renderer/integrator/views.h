#pragma once

#include <memory>

#include "renderer/integrator/integrator.h"

namespace tessera {

// Views of the first surface for finding faults in scenes; black where there is none.

/// The shading normal towards the viewer in world axes: (n + 1) / 2 as red, green, blue.
std::unique_ptr<const Integrator> make_normals_view(std::shared_ptr<const Scene> scene);
/// Metres along the ray, in all channels.
std::unique_ptr<const Integrator> make_depth_view(std::shared_ptr<const Scene> scene);

}  // namespace tessera
