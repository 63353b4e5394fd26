#pragma once

#include <memory>

#include "renderer/integrator/integrator.h"

namespace tessera {

/// Light transport by paths from the camera (Kajiya 1986) with next-event estimation, weighted
/// against the BSDF's own directions by the power heuristic (Veach 1997), and Russian roulette.
/// Unbiased; nothing is clamped. What shines is emission, the background and the lights of the
/// scene, these in the units of scene.proto (a white surface that faces a light of intensity 1
/// sends out radiance 1); ambient light, which stands for what this traces, is left out. The
/// light of surfaces and of the background goes through glass by paths alone, that of lights
/// without an extent, which no path meets, straight.
std::unique_ptr<const Integrator> make_path_tracer(std::shared_ptr<const Scene> scene);

}  // namespace tessera
