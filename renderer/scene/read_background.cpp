#include <fmt/format.h>

#include "renderer/math/elementary.h"
#include "renderer/scene/read_shading.h"
#include "renderer/scene/read_transform.h"

namespace tessera {

namespace {

template <typename Colors, typename Angles>
std::vector<Background::Ring> read_rings(const Where& where, std::string_view name,
                                         const Colors& colors, const Angles& angles,
                                         double largest) {
  if (colors.empty() && angles.empty()) return {};
  if (colors.size() != angles.size() + 1) {
    fail_value(where, fmt::format("the number of {} angles", name), std::to_string(angles.size()),
               fmt::format("one fewer than the {} colours", colors.size()));
  }
  std::vector<Background::Ring> rings;
  for (int i = 0; i < colors.size(); ++i) {
    double angle = 0;
    if (i > 0) {
      const double before = i > 1 ? angles[i - 2] : 0;
      angle = portable::radians(checked(where, fmt::format("{}_angles", name), angles[i - 1],
                                        {.min = before, .max = largest, .above_min = true}));
    }
    rings.push_back({angle, checked(where, name, colors[i])});
  }
  return rings;
}

/// The turn of a transform, without its scale: its axes made square to each other.
std::array<Vec3, 3> rotation_rows(const Affine& m) {
  const Vec3 x = normalize(Vec3{m.m[0][0], m.m[1][0], m.m[2][0]});
  const Vec3 y_raw{m.m[0][1], m.m[1][1], m.m[2][1]};
  const Vec3 y = normalize(y_raw - x * dot(x, y_raw));
  const Vec3 z_raw{m.m[0][2], m.m[1][2], m.m[2][2]};
  Vec3 z = cross(x, y);
  if (dot(z, z_raw) < 0) z = -z;
  return {x, y, z};  // the columns of world from background are the rows of its inverse
}

void read_cube(const Where& where, const v1::Background::Cube& in, TextureTable& textures,
               Background& out) {
  const auto face = [&](Background::Face number, std::string_view field, const std::string& name) {
    if (name.empty()) return;
    out.cube[number] = textures.use_image(where, field, name);
    out.has_cube = true;
  };
  face(Background::front, "cube.front", in.front());
  face(Background::back, "cube.back", in.back());
  face(Background::left, "cube.left", in.left());
  face(Background::right, "cube.right", in.right());
  face(Background::top, "cube.top", in.top());
  face(Background::bottom, "cube.bottom", in.bottom());
}

std::shared_ptr<const Sky> read_daylight(const Where& where, const v1::Background::SunAndSky& in) {
  const Vec3 to_sun = checked_direction(where, "sun_and_sky.sun_direction", in.sun_direction());
  const double turbidity = in.has_turbidity() ? checked(where, "sun_and_sky.turbidity",
                                                        in.turbidity(), {.min = 2, .max = 10})
                                              : 3;
  const double intensity =
      in.has_intensity() ? checked(where, "sun_and_sky.intensity", in.intensity(), kNotNegative)
                         : 1;
  return std::make_shared<Sky>(normalize(to_sun), turbidity, intensity,
                               checked(where, "sun_and_sky.ground_albedo", in.ground_albedo()));
}

}  // namespace

Background read_background(const v1::Background& in, TextureTable& textures) {
  const Where where{.kind = "background"};
  Background out;
  switch (in.kind_case()) {
    case v1::Background::kSolid:
      out.sky = checked(where, "solid", in.solid());
      break;
    case v1::Background::kGradient:
      out.kind = in.gradient().model() == v1::Background::Gradient::ABSOLUTE_Y
                     ? BackgroundKind::gradient_absolute
                     : BackgroundKind::gradient_linear;
      out.sky = checked(where, "gradient.sky", in.gradient().sky());
      out.ground = checked(where, "gradient.ground", in.gradient().ground());
      break;
    case v1::Background::kRings:
      out.kind = BackgroundKind::rings;
      out.sky_rings = read_rings(where, "sky", in.rings().sky(), in.rings().sky_angles(), 180);
      out.ground_rings =
          read_rings(where, "ground", in.rings().ground(), in.rings().ground_angles(), 90);
      break;
    case v1::Background::kPanorama:
      out.kind = in.panorama().mapping() == v1::Background::Panorama::CYLINDRICAL_EQUAL_AREA
                     ? BackgroundKind::panorama_equal_area
                     : BackgroundKind::panorama_equirectangular;
      out.picture = textures.use_image(where, "panorama.texture", in.panorama().texture());
      out.angle = portable::radians(checked(where, "panorama.angle", in.panorama().angle()));
      if (in.panorama().has_intensity()) {
        out.intensity =
            checked(where, "panorama.intensity", in.panorama().intensity(), kNotNegative);
      }
      break;
    case v1::Background::kSunAndSky:
      out.kind = BackgroundKind::sun_and_sky;
      out.daylight = read_daylight(where, in.sun_and_sky());
      break;
    case v1::Background::KIND_NOT_SET:
      break;
  }
  if (in.has_cube()) read_cube(where, in.cube(), textures, out);
  out.glow = checked(where, "glow", in.glow(), kNotNegative);
  out.transparency = checked(where, "transparency", in.transparency(), kUnitRange);
  if (in.has_orientation()) {
    const Affine orientation = read_transform(where, in.orientation());
    if (!is_invertible(orientation)) {
      fail_value(where, "orientation", "flat", "a transform that can be inverted");
    }
    out.rotation = rotation_rows(orientation);
  }
  return out;
}

Fog read_fog(const v1::Fog& in) {
  const Where where{.kind = "fog"};
  Fog out;
  out.visibility_range = checked(where, "visibility_range", in.visibility_range(), kNotNegative);
  if (in.has_color()) out.color = checked(where, "color", in.color());
  if (out.visibility_range > 0) {
    out.kind = in.kind() == v1::Fog::EXPONENTIAL ? FogKind::exponential : FogKind::linear;
  }
  return out;
}

}  // namespace tessera
