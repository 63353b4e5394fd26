#include "scenes/import/standard_view.h"

#include <algorithm>
#include <array>
#include <iterator>

#include "scenes/import/put_vec3.h"

namespace tessera {
namespace {

struct NamedView {
  const char* name;
  Vec3 from, up;  ///< where y is up
};

const std::array<NamedView, 8>& views() {
  static const std::array<NamedView, 8> all{{{"front", {0, 0, 1}, {0, 1, 0}},
                                             {"back", {0, 0, -1}, {0, 1, 0}},
                                             {"left", {-1, 0, 0}, {0, 1, 0}},
                                             {"right", {1, 0, 0}, {0, 1, 0}},
                                             {"side", {1, 0, 0}, {0, 1, 0}},
                                             {"top", {0, 1, 0}, {0, 0, -1}},
                                             {"bottom", {0, -1, 0}, {0, 0, 1}},
                                             {"iso", normalize(Vec3{0.55, 0.38, 1}), {0, 1, 0}}}};
  return all;
}

}  // namespace

const std::vector<std::string>& standard_view_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> out;
    for (const NamedView& view : views()) out.emplace_back(view.name);
    return out;
  }();
  return names;
}

StandardView standard_view(const std::string& name, bool z_is_up) {
  const auto at = std::find_if(views().begin(), views().end(),
                               [&name](const NamedView& view) { return view.name == name; });
  const NamedView& view = at == views().end() ? views().back() : *at;
  return {stood_up(view.from, z_is_up), stood_up(view.up, z_is_up)};
}

void stand_up(v1::Transform& transform) {
  v1::AxisAngle& turn = *transform.add_steps()->mutable_rotate();
  put_vec3({1, 0, 0}, turn.mutable_axis());
  turn.set_angle(90);
}

v1::Camera standard_camera(const std::string& name, bool z_is_up, double field_of_view) {
  const StandardView view = standard_view(name, z_is_up);
  v1::Camera camera;
  camera.set_name(name);
  v1::LookAt& look = *camera.mutable_world_from_camera()->add_steps()->mutable_look_at();
  put_vec3(view.from, look.mutable_eye());
  look.mutable_target();
  if (!(view.up == Vec3{0, 1, 0})) put_vec3(view.up, look.mutable_up());
  camera.mutable_perspective()->set_field_of_view(field_of_view);
  camera.set_frame_all(true);
  return camera;
}

}  // namespace tessera
