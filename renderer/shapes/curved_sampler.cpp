#include "renderer/shapes/curved_sampler.h"

#include <algorithm>
#include <cmath>

#include "renderer/math/elementary.h"
#include "renderer/math/warp.h"
#include "renderer/shapes/area_density.h"

namespace tessera {

namespace {

constexpr double kTurn = 2 * portable::kPi;

/// In the shape's frame.
struct CurvedPoint {
  Point3 point;
  Vec3 normal;  ///< unit; out
};

/// Each kind of surface gives its points.
class CurvedSampler : public SurfaceSampler {
 public:
  /// `area` and `box` in the shape's frame.
  CurvedSampler(double area, const Bounds3& box, const Transform& to_world, bool flip)
      : own_area_(area),
        to_world_(to_world),
        flip_(flip),
        bounds_(to_world.bounds(box)),
        reach_(length(bounds_.diagonal())) {}
  double sample(const LitPoint& from, const Vec2& u, SurfaceSample& sample) const override {
    const CurvedPoint chosen = choose(u);
    sample.point = to_world_.point(chosen.point);
    sample.point_error = rounding_of(sample.point, reach_);
    const Vec3 normal = normalize(static_cast<Vec3>(to_world_.normal(to_normal(chosen.normal))));
    sample.normal = flip_ ? -normal : normal;
    return density(from, sample.point, sample.normal, 0);
  }
  double density(const LitPoint& from, const Point3& there, const Vec3& normal,
                 uint32_t) const override {
    return density_by_area(own_area_ * area_growth(to_world_.matrix(), normal), from.at, there,
                           normal);
  }
  /// About, where the transform is no similarity.
  double area() const override {
    const double scale = portable::pow(std::abs(to_world_.matrix().determinant()), 2.0 / 3);
    return std::max(own_area_ * scale, 1e-300);
  }
  Bounds3 bounds() const override { return bounds_; }

 private:
  virtual CurvedPoint choose(const Vec2& u) const = 0;

  double own_area_;
  Transform to_world_;
  bool flip_;
  Bounds3 bounds_;
  double reach_;
};

Bounds3 box_of(double across, double up) { return {{-across, -up, -across}, {across, up, across}}; }

class EllipsoidSampler final : public CurvedSampler {
 public:
  EllipsoidSampler(const Point3& center, double radius, const Transform& to_world, bool flip)
      : CurvedSampler(
            2 * kTurn * radius * radius,
            {center - Vec3{radius, radius, radius}, center + Vec3{radius, radius, radius}},
            to_world, flip),
        center_(center),
        radius_(radius) {}

 private:
  CurvedPoint choose(const Vec2& u) const override {
    const Vec3 out = direction_at(1 - 2 * u.x, u.y);
    return {center_ + out * radius_, out};
  }
  Point3 center_;
  double radius_;
};

class FrustumSampler final : public CurvedSampler {
 public:
  FrustumSampler(const FrustumParts& parts, const Transform& to_world, bool flip)
      : CurvedSampler(area_of(parts),
                      box_of(std::max(parts.bottom_radius, parts.top_radius), parts.half_height),
                      to_world, flip),
        parts_(parts) {}
  static double area_of(const FrustumParts& parts) {
    return side_area(parts) + top_area(parts) + bottom_area(parts);
  }

 private:
  static double slant(const FrustumParts& p) {
    return std::hypot(2 * p.half_height, p.bottom_radius - p.top_radius);
  }
  static double side_area(const FrustumParts& p) {
    return p.open.side ? 0 : kTurn / 2 * (p.bottom_radius + p.top_radius) * slant(p);
  }
  static double top_area(const FrustumParts& p) {
    return p.open.top ? 0 : kTurn / 2 * p.top_radius * p.top_radius;
  }
  static double bottom_area(const FrustumParts& p) {
    return p.open.bottom ? 0 : kTurn / 2 * p.bottom_radius * p.bottom_radius;
  }
  CurvedPoint choose(const Vec2& u) const override {
    double at = u.x * area_of(parts_);
    const auto is_in = [&](double area) {
      if (at < area) {
        at = std::min(at / area, 0x1.fffffffffffffp-1);
        return true;
      }
      at -= area;
      return false;
    };
    if (is_in(side_area(parts_))) return on_side({at, u.y});
    if (is_in(top_area(parts_))) return on_cap({at, u.y}, parts_.top_radius, 1);
    if (is_in(bottom_area(parts_))) return on_cap({at, u.y}, parts_.bottom_radius, -1);
    return parts_.open.side ? on_cap(u, parts_.open.top ? parts_.bottom_radius : parts_.top_radius,
                                     parts_.open.top ? -1 : 1)
                            : on_side(u);  // past the last by rounding
  }
  /// As many points at each height as there is room around it.
  CurvedPoint on_side(const Vec2& u) const {
    const double r0 = parts_.bottom_radius, r1 = parts_.top_radius;
    const double radius = std::sqrt(r0 * r0 + u.x * (r1 * r1 - r0 * r0));
    // The share of the height.
    const double up = r0 + radius > 0 ? u.x * (r0 + r1) / (r0 + radius) : 0;
    const double azimuth = kTurn * u.y;
    const double x = portable::cos(azimuth), z = portable::sin(azimuth);
    const double height = 2 * parts_.half_height, along = height / slant(parts_);
    return {{radius * x, parts_.half_height * (2 * up - 1), radius * z},
            {along * x, (r0 - r1) / slant(parts_), along * z}};
  }
  CurvedPoint on_cap(const Vec2& u, double radius, double side) const {
    const Vec2 d = disc_point(u);
    return {{radius * d.x, side * parts_.half_height, radius * d.y}, {0, side, 0}};
  }

  FrustumParts parts_;
};

class TorusSampler final : public CurvedSampler {
 public:
  TorusSampler(double major, double minor, const Transform& to_world, bool flip)
      : CurvedSampler(kTurn * kTurn * major * minor, box_of(major + minor, minor), to_world, flip),
        major_(major),
        minor_(minor) {}

 private:
  CurvedPoint choose(const Vec2& u) const override {
    const double azimuth = kTurn * u.x, tube = tube_angle(kTurn * u.y);
    const double x = portable::cos(azimuth), z = portable::sin(azimuth);
    const double out = portable::cos(tube), up = portable::sin(tube);
    const double from_axis = major_ + minor_ * out;
    return {{from_axis * x, minor_ * up, from_axis * z}, {out * x, up, out * z}};
  }
  /// Of the equation a + e sin a = `share`, which has the tube's outside more often than its inside
  /// (Kepler's, from the other apsis); by halving, since Newton's steps may leave at e near 1.
  double tube_angle(double share) const {
    const double e = minor_ / major_;
    double low = 0, high = kTurn, a = share;
    for (int i = 0; i < 100 && low < high; ++i) {
      const double rest = a + e * portable::sin(a) - share;
      if (rest == 0) break;
      (rest > 0 ? high : low) = a;
      const double step = a - rest / (1 + e * portable::cos(a));
      const double next = step > low && step < high ? step : low + (high - low) / 2;
      if (std::abs(next - a) <= 0x1p-50 * kTurn) return next;
      a = next;
    }
    return a;
  }

  double major_, minor_;
};

}  // namespace

std::unique_ptr<const SurfaceSampler> make_ellipsoid_sampler(const Point3& center, double radius,
                                                             const Transform& world_from_object,
                                                             bool flip_normals) {
  return std::make_unique<EllipsoidSampler>(center, radius, world_from_object, flip_normals);
}

std::unique_ptr<const SurfaceSampler> make_frustum_sampler(const FrustumParts& parts,
                                                           const Transform& world_from_object,
                                                           bool flip_normals) {
  if (!(FrustumSampler::area_of(parts) > 0)) return nullptr;
  return std::make_unique<FrustumSampler>(parts, world_from_object, flip_normals);
}

std::unique_ptr<const SurfaceSampler> make_torus_sampler(double major_radius, double minor_radius,
                                                         const Transform& world_from_object,
                                                         bool flip_normals) {
  if (minor_radius > major_radius) return nullptr;
  return std::make_unique<TorusSampler>(major_radius, minor_radius, world_from_object,
                                        flip_normals);
}

}  // namespace tessera
