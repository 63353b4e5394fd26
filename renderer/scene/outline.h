#pragma once

#include <vector>

#include "proto/tessera/v1/scene.pb.h"
#include "renderer/scene/read_shape.h"

namespace tessera {

/// Points in the shape's frame whose convex hull is about the shape's: vertices of meshes, and
/// points of round shapes that leave out a hundredth of their radius at most; of others the corners
/// of the box, of all unless `closely`. None of what is endless or empty.
std::vector<Point3> outline(const v1::Shape& description, const BuiltShape& built, bool closely);
/// The eight of them.
std::vector<Point3> box_corners(const Bounds3& box);
/// How many points outline() has at most.
size_t outline_limit(const BuiltShape& built);

}  // namespace tessera
