#pragma once

#include <memory>
#include <optional>

#include "renderer/integrator/integrator.h"

namespace tessera {

/// What a camera ray shows of the first surface that it meets and that covers at least half of what
/// is behind it.
struct FirstSurface {
  Color albedo;      ///< the share of light from everywhere that it sends on
  Vec3 normal;       ///< for shading, unit, towards the viewer, world axes
  double depth = 0;  ///< metres along the ray
  Point3 position;   ///< world
  uint32_t instance = 0;
  uint32_t primitive = 0;  ///< as in Hit
};
std::optional<FirstSurface> first_surface(const Scene& scene, const Ray& ray, TraceState& state);

// Views for finding faults in scenes; black where nothing is seen.

/// What the first surface is:
///   normals    the shading normal towards the viewer in world axes, (n + 1) / 2 as RGB
///   depth      metres along the ray, in all channels
///   albedo     the share of light from everywhere that it sends on, as its material has it
///   ids        a colour for each material of each instance
///   wireframe  edges of triangles as dark lines, 1.2 pixels wide
/// Null for a view that is none of a surface.
std::unique_ptr<const Integrator> make_surface_view(std::shared_ptr<const Scene> scene, View view);

/// How many nodes are visited and primitives tested by `inner`, a sample, in all channels.
std::unique_ptr<const Integrator> make_cost_view(std::unique_ptr<const Integrator> inner);

}  // namespace tessera
