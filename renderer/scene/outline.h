#pragma once

#include <vector>

#include "renderer/scene/read_shape.h"

namespace tessera {

/// Points in the shape's frame whose convex hull is about the shape's: the vertices of a mesh, the
/// outline() of others; the corners of the box, unless `closely`. None of what is endless or empty.
std::vector<Point3> outline(const BuiltShape& built, bool closely);
/// How many points outline() has at most.
size_t outline_limit(const BuiltShape& built);

}  // namespace tessera
