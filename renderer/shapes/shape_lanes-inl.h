// Compiled once for each instruction set: points of shapes, and surfaces in world space, of many
// rays, a lane each.
#if defined(TESSERA_SHAPE_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TESSERA_SHAPE_LANES_INL_H
#undef TESSERA_SHAPE_LANES_INL_H
#else
#define TESSERA_SHAPE_LANES_INL_H
#endif

#include <hwy/highway.h>

#include "renderer/math/lanes-inl.h"
#include "renderer/math/rounding.h"
#include "renderer/math/transform.h"
#include "renderer/shapes/convex_polygon.h"
#include "renderer/shapes/plane.h"
#include "renderer/shapes/sphere.h"
#include "renderer/shapes/surface_interaction.h"

HWY_BEFORE_NAMESPACE();
namespace tessera {
namespace HWY_NAMESPACE {

#include "renderer/math/transform-inl.h"
#include "renderer/shapes/plane-inl.h"
#include "renderer/shapes/rectangle-inl.h"
#include "renderer/shapes/sphere-inl.h"
#include "renderer/shapes/surface_interaction-inl.h"
#include "renderer/shapes/triangle-inl.h"

}  // namespace HWY_NAMESPACE
}  // namespace tessera
HWY_AFTER_NAMESPACE();

#endif
