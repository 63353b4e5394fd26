#include <fmt/format.h>

#include <array>

#include "base/lower_case.h"
#include "scenes/formats/crt/crt_objects.h"

namespace tessera {
namespace {

struct Aperture {
  std::string_view name;
  v1::Lens::Shape shape;
  uint32_t blades;
};

constexpr std::array<Aperture, 8> kApertures{{
    {"circle", v1::Lens::CIRCLE, 0},
    {"line", v1::Lens::LINE, 0},
    {"triangle", v1::Lens::POLYGON, 3},
    {"square", v1::Lens::POLYGON, 4},
    {"pentagon", v1::Lens::POLYGON, 5},
    {"hexagon", v1::Lens::POLYGON, 6},
    {"uniform", v1::Lens::SQUARE_UNIFORM, 0},
    {"gaussian", v1::Lens::GAUSSIAN, 0},
}};

/// Of `names`, the one that the attribute names without regard to case, or null after a report.
template <typename Names>
auto choose(CrtAttributes& in, std::string_view attribute, const Names& names, auto name_of)
    -> const typename Names::value_type* {
  const std::string chosen = lower_case(in.text(attribute, name_of(names.front())));
  std::vector<std::string> known;
  for (const auto& entry : names) {
    if (name_of(entry) == chosen) return &entry;
    known.emplace_back(name_of(entry));
  }
  in.wrong(*in.find(attribute),
           fmt::format("one of {}{}", fmt::join(known, ", "), suggestion(chosen, known)));
  return nullptr;
}

/// The frame of the original, whose world is left-handed: x is right, y up, and it looks along +z
/// of the matrix' third row turned round. Straight up and down have an up of their own.
void place(const Vec3& position, const Vec3& pointing, v1::Camera& camera) {
  const Vec3 view = normalize(pointing - position);
  Vec3 up{0, 1, 0};
  if (view.x == 0 && view.z == 0) up = {view.y > 0 ? 1.0 : -1.0, 0, 0};
  const Vec3 right = -normalize(cross(view, up));
  up = cross(view, right);
  v1::Matrix& matrix = *camera.mutable_world_from_camera()->add_steps()->mutable_matrix();
  for (int row = 0; row < 3; ++row)
    for (const double entry : {right[row], up[row], -view[row], position[row]})
      matrix.add_rows(entry);
}

void read_projection(CrtAttributes& in, v1::Camera& camera) {
  static constexpr std::array<std::string_view, 3> kProjections{"pinhole", "spherical",
                                                                "cylindrical"};
  const auto* projection =
      choose(in, "projection", kProjections, [](std::string_view name) { return name; });
  const bool is_spherical = projection && *projection == "spherical";
  const double most = is_spherical ? 360 : 180;
  const double fov =
      in.number("fov", {.min = 0, .max = most, .above_min = true, .below_max = !is_spherical});
  if (is_spherical) {
    camera.mutable_spherical()->set_field_of_view(fov);
  } else if (projection && *projection == "cylindrical") {
    camera.mutable_cylindrical()->set_field_of_view(fov);
  } else {
    camera.mutable_perspective()->set_field_of_view(fov);
    camera.mutable_perspective()->set_axis(v1::Perspective::VERTICAL);
  }
}

}  // namespace

CrtValue make_crt_camera(CrtAttributes& in, CrtHeap& heap) {
  CrtCamera made;
  v1::Camera& camera = made.message;
  const Vec3 position = in.vector("position"), pointing = in.vector("pointing");
  const bool has_both = in.has("position") && in.has("pointing");
  if (has_both && !(length(pointing - position) > 0))
    in.fail(in.where(), "Camera that points to its own position", "two different points");
  place(position, pointing, camera);
  read_projection(in, camera);
  v1::Lens& lens = *camera.mutable_lens();
  const double aperture = in.number("aperture", kCrtNotNegative, 3);
  lens.set_radius_x(aperture);
  lens.set_radius_y(aperture);
  lens.set_radius_unit(v1::Lens::METRES_OVER_FRAME);
  lens.set_focal_distance(in.number("focaldistance", kCrtPositive, 0.5));
  lens.set_focal_surface(v1::Lens::SPHERE);
  const auto* shape = choose(in, "apertureshape", kApertures,
                             [](const Aperture& aperture_shape) { return aperture_shape.name; });
  if (shape) {
    lens.set_shape(shape->shape);
    lens.set_blades(shape->blades);
  }
  if (!in.finish()) return CrtFailed{};
  return heap.add(std::move(made), in.where());
}

}  // namespace tessera
