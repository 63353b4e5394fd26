"""The bugs that the tests must catch (N31): each is one change of one place in the source."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Mutation:
    name: str
    file: str
    old: str  # must occur exactly once
    new: str
    program: str  # the test program that must fail
    tests: str  # GoogleTest filter: those that are run, until the first fails
    quick: bool = False  # part of the run that CI makes


TRIANGLE = "renderer/shapes/triangle.h"
SCALAR_SIGNS = "s.u >= 0 && s.v >= 0 && s.w >= 0;\n  const bool all_down = s.u <= 0 && s.v <= 0 && s.w <= 0;\n  if"

MUTATIONS = [
    # Those that the specification names.
    Mutation("barycentric point: gamma(7) becomes gamma(1)", "renderer/shapes/triangle_mesh.cpp",
             "gamma(7) * size", "gamma(1) * size", "numerics_test", "N10.*", quick=True),
    Mutation("no gate on t", "renderer/shapes/triangle.cpp",
             "if (!(t > error) && !clearly_ahead(ray, s)) return false;", "(void)error;",
             "numerics_test", "N10.*", quick=True),
    Mutation("edges: < for <=", TRIANGLE, SCALAR_SIGNS,
             SCALAR_SIGNS.replace(">= 0", "> 0").replace("<= 0", "< 0"),
             "numerics_test", "Offset/N02.*/0:Offset/N02.*/3"),
    Mutation("edges: < for <= in the kernels", "renderer/accel/test_triangles-inl.h",
             "hn::Ge(hn::Min(hn::Min(s.u, s.v), s.w), zero)",
             "hn::Gt(hn::Min(hn::Min(s.u, s.v), s.w), zero)", "numerics_test",
             "Offset/N02.*/0:*N21*:*N22*"),
    Mutation("octant from the direction, not from its sign bit", "renderer/accel/box_ray.h",
             "(backward[a] < 0 ? 1 : 0)", "(ray.direction[a] < 0 ? 1 : 0)",
             "numerics_test", "N15.*"),
    # No radiometry here divides by pi or by a density: the nearest of that kind.
    Mutation("Lambert's share larger by pi", "renderer/shading/material.h",
             "factor = std::max(n_dot_l, 0.0);", "factor = std::max(n_dot_l, 0.0) * 3.141592653589793;",
             "render_test", "*"),
    Mutation("light falls off 2 % too fast", "renderer/shading/light.h",
             "denominator > 0 ? a.scale / denominator : 0;",
             "denominator > 0 ? 0.98 * a.scale / denominator : 0;",
             "render_test", "*"),
    # The rest of the techniques that the core relies on.
    Mutation("error of t in mixed units", TRIANGLE, "max_z * ray.depth", "max_z",
             "numerics_test", "*N22.*"),
    Mutation("signs of edges that are rounded to zero are not looked at again", TRIANGLE,
             "if (!sharpen_edges(s)) return false;", "", "numerics_test", "*N04.*:*N20.*:N18.*"),
    Mutation("t of triangles seen edge-on stays outside of their box",
             "renderer/shapes/triangle.cpp", "t = clamp_to_box(ray.ray, corners, t);",
             "(void)clamp_to_box(ray.ray, corners, t);", "numerics_test",
             "N20.*:Seed/N04.*:Seed/N2*"),
    Mutation("boxes without a margin", "renderer/accel/box_ray.h", "kMargin = 0x1p-19",
             "kMargin = 0x1p-60", "numerics_test", "Offset/N02.*/0:Offset/N02.*/3:N15.*"),
    Mutation("boxes a thousandth too small", "renderer/accel/wide_tree.cpp",
             "low{float_down(b.min.x)", "low{float_up(b.min.x + 1e-3 * std::abs(b.min.x))",
             "numerics_test", "Seed/N20.*"),
    Mutation("ties go to the larger triangle", "renderer/accel/linear_scan.cpp",
             "primitive >= hit.primitive", "primitive < hit.primitive", "numerics_test",
             "N15.*:N18.*"),
    Mutation("sphere: the textbook discriminant", "renderer/shapes/sphere.cpp",
             "(radius_ + from_axis) * (radius_ - from_axis);",
             "(b * b - a * (dot(f, f) - radius_ * radius_)) / a + 0 * from_axis;",
             "numerics_test", "N06.*", quick=True),
    Mutation("sphere: origin + t * direction as the point", "renderer/shapes/sphere.cpp",
             "s.point = center_ + n * radius_;", "s.point = ray.at(hit.t);",
             "numerics_test", "N11.*"),
    Mutation("rays leave to the front only", "renderer/shapes/surface_interaction.cpp",
             "(behind ? -reach : reach)", "reach", "numerics_test", "N10.*:N11.*",
             quick=True),
    Mutation("spawned rays: the way into the frame and back is exact",
             "renderer/shapes/surface_interaction.cpp",
             "s.point_error = world_from_object.point_error(s.point, s.point_error) +\n"
             "                  round_trip_error(world_from_object, world);",
             "(void)round_trip_error;\n  s.point_error = "
             "world_from_object.point_error(s.point, s.point_error);",
             "numerics_test", "N10.*:N11.*:*N23.*:*N24.*"),
    Mutation("shadow rays leave the facets of smooth meshes",
             "renderer/integrator/direct_light.cpp",
             "return dot(point.surface.smooth_shift, point.geometric_normal) > 0 &&",
             "return dot(point.surface.smooth_shift, point.geometric_normal) > 1e300 &&",
             "numerics_render_test", "*N25*"),
    Mutation("instances: direction of unit length", "renderer/accel/instance.cpp",
             "place.inverse_vector(ray.direction), ray.t_min",
             "normalize(place.inverse_vector(ray.direction)), ray.t_min", "numerics_test",
             "*N23.*"),
    Mutation("normals go by the matrix itself", "renderer/math/transform.cpp",
             "const auto& m = from_.m;\n  return {m[0][0] * n.x + m[1][0]",
             "const auto& m = to_.m;\n  return {m[0][0] * n.x + m[1][0]",
             "numerics_test", "*N23.*:*N24.*"),
    Mutation("ties between instances by primitive", "renderer/accel/instance.cpp",
             "if (number > hit.instance) hit.primitive = 0;", "", "numerics_test",
             "Seed/N20.*"),
    Mutation("torus: turning points by the quartic alone", "renderer/shapes/torus.cpp",
             "if (std::abs(turn.distance) < 0.01 * minor_) {", "if (turn.distance != turn.distance) {",
             "numerics_shapes_test", "N07.*Sharpened"),
    Mutation("flat shapes: no gate on the height", "renderer/shapes/planar.h",
             "gamma(2) * dot(abs(normal), abs(from_anchor))", "0", "numerics_shapes_test",
             "N10.*"),
    Mutation("planes: no gate on the height", "renderer/shapes/plane.h",
             "return std::abs(height) > distance_error(ray.origin);", "return height != 0;",
             "numerics_shapes_test", "N10.*"),
    Mutation("boxes of trees too fine for single precision: as small a margin as for none",
             "renderer/accel/tree_boxes.cpp", ".space = 0x1p-32", ".space = 0x1p-70",
             "numerics_test", "Offset/N02.*/7"),
    Mutation("quadratic: the textbook discriminant", "renderer/math/quadratic.h",
             "difference_of_products(b, b, 4 * a, c)", "b * b - 4 * a * c",
             "numerics_shapes_test", "*N09.*"),
    Mutation("CSG: transforms of operands are exact", "renderer/shapes/csg_sweep.cpp",
             "kTransformError = gamma(8)", "kTransformError = 0", "numerics_shapes_test",
             "*N1*:*N22*"),
    Mutation("cone: error bound of the side too small", "renderer/shapes/frustum.cpp",
             "s.point_error = {std::abs(out.x) * radius_error,",
             "s.point_error = {0.1 * std::abs(out.x) * radius_error,", "numerics_shapes_test",
             "*N11.*"),
]
