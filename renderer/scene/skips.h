#pragma once

namespace tessera {

/// Work that is left out where the picture does not depend on it, or hardly: docs/skipping.md tells
/// why, and what each saves. All are left out but in `tessera bench skip`, which takes them in one
/// by one. A value, part of the built scene; it is no setting, and travels nowhere.
struct Skips {
  // When the scene is built.
  bool small_trees = true;        ///< trees over one or two things or few instances
  bool unhit_meshes = true;       ///< trees of meshes that no ray comes near
  bool unused_attributes = true;  ///< normals, texture coordinates and colours that nothing reads
  bool unused_textures = true;    ///< textures that nothing names
  bool dark_lights = true;        ///< black lights
  bool distant_lights = true;     ///< lights of which a list by place tells that they end before
  bool shadowless_planes = true;  ///< grounds that have everything on their lights' side
  bool opaque_as_clear = true;    ///< asking what is opaque how much it lets through
  bool absent_features = true;    ///< asking every hit for what no material of the scene has
  // A pixel or block at a time.
  bool background_pixels = true;  ///< rays past everything
  bool equal_samples = true;      ///< samples that are all alike
  bool converged_blocks = true;   ///< samples beyond the error asked for
  // Where a ray ends. Tested only where there is something to leave out, so that others pay
  // nothing.
  bool dark_shadow_rays = true;  ///< to lights of which the surface would send nothing on
  bool unreached_lights = true;  ///< shadow rays to lights that do not reach so far
  bool last_occluder = true;     ///< the search for what stops a shadow ray, where the last one to
                                 ///< the same light was stopped by it too
  bool unread_numbers = true;    ///< random numbers that no decision reads
  bool texture_points = true;    ///< the patch of surface that a texture is looked up on
  bool faint_branches = true;    ///< mirrors and glass of a whole weight below 1e-9
};

/// For what is worked out only to know its cost: the compiler must take it as read.
template <typename Value>
void keep_result(const Value& value) {
  asm volatile("" : : "r"(&value) : "memory");
}

}  // namespace tessera
