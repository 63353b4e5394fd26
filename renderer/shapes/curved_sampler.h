#pragma once

#include <memory>

#include "renderer/math/transform.h"
#include "renderer/shapes/frustum.h"
#include "renderer/shapes/surface_sampler.h"

namespace tessera {

// Points spread evenly over curved surfaces in their own frame; a transform that is no similarity
// spreads them unevenly.

std::unique_ptr<const SurfaceSampler> make_ellipsoid_sampler(const Point3& center, double radius,
                                                             const Transform& world_from_object,
                                                             bool flip_normals);
/// Of the parts that are there; null where none has an area.
std::unique_ptr<const SurfaceSampler> make_frustum_sampler(const FrustumParts& parts,
                                                           const Transform& world_from_object,
                                                           bool flip_normals);
/// Null for a spindle, where some of it lies inside.
std::unique_ptr<const SurfaceSampler> make_torus_sampler(double major_radius, double minor_radius,
                                                         const Transform& world_from_object,
                                                         bool flip_normals);

}  // namespace tessera
