// Written once for single numbers and for lanes (numbers.h): included by sphere.h, and by
// shape_lanes-inl.h for each instruction set.

/// Takes a point that an intersection found onto the sphere; `normal` points out of it there, and
/// `error` is how far off the point may be.
TESSERA_INLINE void place_on_sphere(const Num3& center, Num radius, Num3& point, Num3& normal,
                                    Num3& error) {
  normal = normalize(point - center);
  point = center + normal * radius;
  error = (abs(center) + abs(normal) * (num(5) * radius) + abs(point)) * num(kUnitRoundoff);
}

/// A line against a sphere about the origin.
struct SphereLine {
  Num3 from, along;  ///< a point of the line, and its direction
  Num radius;
  Num speed = dot(along, along), squared = dot(from, from), toward = dot(from, along);

  /// A cheap test, without roots and divisions, that most misses pass; where it says nothing the
  /// roots decide. `is_ahead`: only what lies ahead of `from` counts.
  TESSERA_INLINE NumMask surely_misses(NumMask is_ahead) const {
    const Num margin = num(kSphereMargin), area = radius * radius, whole = speed * squared;
    const NumMask lies_behind =
        both(both(toward > num(0), is_ahead), squared - area > margin * squared);
    const Num off = whole - toward * toward - speed * area;
    return both(whole > num(kLeastSphereProduct), either(lies_behind, off > margin * whole));
  }
  /// Whether there are roots, which come in ascending order.
  TESSERA_INLINE NumMask roots(Num& enter, Num& leave) const {
    // Haines, Guenther, Akenine-Moller: Precision Improvements for Ray/Sphere Intersection (Ray
    // Tracing Gems 7). The distance of the line from the centre is taken before it is squared.
    const Num b = negated(toward);
    const Num3 nearest = from + along * (b / speed);
    const Num from_axis = square_root(dot(nearest, nearest)), distance = square_root(squared);
    const Num discriminant = (radius + from_axis) * (radius - from_axis);
    const Num c = (distance + radius) * (distance - radius);
    const Num q = b + copy_sign(square_root(speed * discriminant), b);
    const NumMask touches = q == num(0);
    const Num one = select(touches, num(0), c / q), other = select(touches, num(0), q / speed);
    const NumMask is_swapped = one > other;
    enter = select(is_swapped, other, one);
    leave = select(is_swapped, one, other);
    return discriminant >= num(0);
  }
};
