#pragma once

#include "renderer/scene/scene.h"

namespace tessera {

/// The radiance of the brightest light or the sun where mirrors or smooth glass throw light on:
/// paths that come to these from other surfaces meet it by chance alone. 1, display white, at
/// least, and where nothing is followed by paths. Bright pictures of the background are not looked
/// at.
double light_by_chance(const Scene& scene);

}  // namespace tessera
