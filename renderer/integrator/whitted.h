#pragma once

#include <memory>

#include "renderer/integrator/integrator.h"

namespace tessera {

/// Direct light with hard shadows, ideal mirrors and clear refraction (Whitted 1980).
std::unique_ptr<const Integrator> make_whitted(std::shared_ptr<const Scene> scene);

}  // namespace tessera
