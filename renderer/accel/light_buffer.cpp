#include "renderer/accel/light_buffer.h"

namespace tessera {
namespace {

/// What rounding may move a ray by, in parts of a direction and of the scene.
constexpr double kSlack = 1e-9;

double least_square(double low, double high) {
  return low > 0 ? low * low : high < 0 ? high * high : 0;
}
/// The least `part` / length of what has a part of at least that, and the rest between.
double least_share(double part, double least_rest, double most_rest) {
  const double rest = part < 0 ? least_rest : most_rest;
  const double squared = part * part + rest;
  return squared > 0 ? part / std::sqrt(squared) : -1;
}

}  // namespace

LightBuffer LightBuffer::of_place(const BoxSoA& boxes, const Point3& place) {
  LightBuffer buffer(boxes);
  buffer.cells_.resize(6 * kSide * kSide);
  for (uint32_t box = 0; boxes.all >> box != 0; ++box) {
    const Vec3 low = place - Point3{boxes.max[0][box], boxes.max[1][box], boxes.max[2][box]};
    const Vec3 high = place - Point3{boxes.min[0][box], boxes.min[1][box], boxes.min[2][box]};
    Range cells[3];
    for (int axis = 0; axis < 3; ++axis) {
      double least = 0, most = 0;  // of the squares of the other two parts
      for (const int other : {(axis + 1) % 3, (axis + 2) % 3}) {
        least += least_square(low[other], high[other]);
        most += std::max(low[other] * low[other], high[other] * high[other]);
      }
      cells[axis] = {place_of(least_share(low[axis], least, most) - kSlack),
                     place_of(-least_share(-high[axis], least, most) + kSlack)};
    }
    for (int axis = 0; axis < 3; ++axis) {
      const Range &columns = cells[(axis + 1) % 3], &rows = cells[(axis + 2) % 3];
      if (high[axis] > 0) buffer.add(box, 2 * axis, columns, rows);
      if (low[axis] < 0) buffer.add(box, 2 * axis + 1, columns, rows);
    }
  }
  return buffer;
}

LightBuffer LightBuffer::of_direction(const BoxSoA& boxes, const Vec3& direction) {
  LightBuffer buffer(boxes);
  buffer.is_place_ = false;
  buffer.cells_.resize(kSide * kSide);
  // Points go along the direction onto the plane across its largest part.
  const Vec3 size = abs(direction);
  const int ahead = size.x > size.y && size.x > size.z ? 0 : size.y > size.z ? 1 : 2;
  const auto measure = [&](int axis) {
    Vec3 along;
    along[axis] = 1;
    along[ahead] = -direction[axis] / direction[ahead];
    return along;
  };
  buffer.right_ = measure((ahead + 1) % 3);
  buffer.down_ = measure((ahead + 2) % 3);
  const auto shadow = [&](uint32_t box, const Vec3& along) {
    const double slack = kSlack * boxes.farthest;
    Range range{-slack, slack};
    for (int axis = 0; axis < 3; ++axis) {
      const double a = boxes.min[axis][box] * along[axis], b = boxes.max[axis][box] * along[axis];
      range.low += std::min(a, b);
      range.high += std::max(a, b);
    }
    return range;
  };
  const auto spread = [&](const Vec3& along, double& least, double& scale) {
    Range all{Bounds3::kInfinity, -Bounds3::kInfinity};
    for (uint32_t box = 0; boxes.all >> box != 0; ++box) {
      const Range one = shadow(box, along);
      all = {std::min(all.low, one.low), std::max(all.high, one.high)};
    }
    least = all.low;
    scale = kSide / (all.high - all.low);
    if (!std::isfinite(scale)) scale = 0;  // all in one cell: too small to be divided
  };
  spread(buffer.right_, buffer.least_.x, buffer.scale_.x);
  spread(buffer.down_, buffer.least_.y, buffer.scale_.y);
  const auto cells = [](const Range& range, double least, double scale) {
    return Range{(range.low - least) * scale, (range.high - least) * scale};
  };
  for (uint32_t box = 0; boxes.all >> box != 0; ++box)
    buffer.add(box, 0, cells(shadow(box, buffer.right_), buffer.least_.x, buffer.scale_.x),
               cells(shadow(box, buffer.down_), buffer.least_.y, buffer.scale_.y));
  return buffer;
}

void LightBuffer::add(uint32_t box, int face, const Range& columns, const Range& rows) {
  // An end that is not a number may be anywhere.
  const auto first = [](const Range& r) {
    return r.low > 0 ? static_cast<int>(std::min(r.low, double{kSide})) : 0;
  };
  const auto last = [](const Range& r) {
    return r.high < kSide - 1 ? static_cast<int>(std::max(r.high, -1.0)) : kSide - 1;
  };
  for (int y = first(rows); y <= last(rows); ++y)
    for (int x = first(columns); x <= last(columns); ++x)
      cells_[index_of(face, x, y)] |= static_cast<uint16_t>(1u << box);
}

}  // namespace tessera
