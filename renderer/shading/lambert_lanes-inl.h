// Compiled once for each instruction set: evenly scattering surfaces at many points, a lane each.
#if defined(TESSERA_LAMBERT_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_LAMBERT_LANES_INL_H
#undef TESSERA_LAMBERT_LANES_INL_H
#else
#define TESSERA_LAMBERT_LANES_INL_H
#endif

#include <hwy/highway.h>

#include "renderer/math/elementary.h"
#include "renderer/math/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

#include "renderer/math/frame-inl.h"
#include "renderer/math/warp-inl.h"
#include "renderer/shading/lambert-inl.h"

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
