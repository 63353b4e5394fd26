#pragma once

#include "renderer/math/numbers.h"

namespace tessera {

#include "renderer/math/frame-inl.h"

}  // namespace tessera
