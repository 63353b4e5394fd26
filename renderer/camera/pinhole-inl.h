// Written once for single numbers and for lanes (numbers.h): included by camera.h, and by
// lane_camera-inl.h for each instruction set.

/// The way of a pinhole's ray through the raster point (x, y), of unit length.
TESSERA_INLINE Num3 pinhole_direction(const Pinhole& camera, Num x, Num y) {
  const Vec3 &ahead = camera.view, &right = camera.right, &up = camera.up;
  const Num u = num(camera.offset.x) + x * num(camera.scale.x);
  const Num v = num(camera.offset.y) + y * num(camera.scale.y);
  return normalize(num3(ahead.x, ahead.y, ahead.z) + num3(right.x, right.y, right.z) * u +
                   num3(up.x, up.y, up.z) * v);
}
