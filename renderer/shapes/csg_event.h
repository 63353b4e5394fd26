#pragma once

#include "renderer/shapes/csg_gates.h"
#include "renderer/shapes/line_box.h"

namespace tessera {

/// A crossing of one operand, in the frame of the whole.
struct CsgEvent {
  double t, low, high;  ///< where it may truly be
  double error;
  uint32_t leaf;
  uint32_t primitive;  ///< within the whole
  int turn;            ///< +1 entering the operand, -1 leaving it
  bool inward;         ///< whether it can only add to the whole: entering a solid, leaving a hole
  double u, v;
};

/// Where a crossing may truly be, on a line that is inside the solid's bounds in `range`: whatever
/// the error, there.
inline double lowest(const SolidEvent& e, const LineRange& range) {
  return std::min(e.t, std::max(e.t - e.error, range.low));
}
inline double highest(const SolidEvent& e, const LineRange& range) {
  return std::max(e.t, std::min(e.t + e.error, range.high));
}

/// A line in the frame of a solid that was moved, and how far it may be from where it seems.
struct LocalLine {
  Ray ray;
  RayError error;
};
LocalLine to_solid(const CsgGates::Leaf& leaf, const Ray& ray, const RayError& error);

/// Whether the ray can hit the whole where it changes; `inward`: and holds from there on.
inline bool is_hit(const Ray& ray, double t, double error, bool inward) {
  // Entering shows the front, leaving the back.
  if (ray.cull == (inward ? Cull::front : Cull::back)) return false;
  // Nearer than its error it may be the surface that the ray starts on.
  return t > ray.t_min && t > error && t < ray.t_max;
}

/// Replaces `hit` where `found` is nearer, as Shape::closest_hit; says whether it did.
inline bool take_nearer(const Hit& found, Hit& hit) {
  if (found.t > hit.t || (found.t == hit.t && found.primitive >= hit.primitive)) return false;
  hit = {found.t, found.u, found.v, hit.instance, found.primitive};
  return true;
}

}  // namespace tessera
