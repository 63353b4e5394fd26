#pragma once

#include "renderer/math/elementary.h"
#include "renderer/math/frame.h"
#include "renderer/math/numbers.h"
#include "renderer/math/warp.h"

namespace tessera {

#include "renderer/shading/lambert-inl.h"

}  // namespace tessera
