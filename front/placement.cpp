#include "front/placement.h"

#include <fmt/format.h>

#include <array>
#include <optional>

#include "base/error.h"
#include "front/option_values.h"

namespace tessera {
namespace {

constexpr std::string_view kOption = "--place";

struct Placement {
  std::optional<std::array<double, 3>> at, rotate, scale;
  std::array<bool, 3> mirror{};
};

std::array<double, 3> three_numbers(std::string_view key, std::string_view text) {
  std::array<double, 3> values{};
  std::string_view rest = text;
  for (size_t i = 0; i < 3; ++i) {
    const size_t comma = rest.find(',');
    if ((comma == std::string_view::npos) != (i == 2)) {
      throw usage_error(fmt::format("{}: '{}={}'; expected three numbers, such as {}=1,0,-2.5",
                                    kOption, key, text, key));
    }
    values[i] = parse_number(fmt::format("{} {}", kOption, key), rest.substr(0, comma));
    rest.remove_prefix(i == 2 ? rest.size() : comma + 1);
  }
  return values;
}

std::array<double, 3> scale_of(std::string_view text) {
  if (text.find(',') != std::string_view::npos) return three_numbers("scale", text);
  const double all = parse_number(fmt::format("{} scale", kOption), text);
  return {all, all, all};
}

std::array<bool, 3> axes_of(std::string_view text) {
  std::array<bool, 3> axes{};
  for (const char c : text) {
    if (c < 'x' || c > 'z' || axes[static_cast<size_t>(c - 'x')]) {
      throw usage_error(fmt::format("{}: 'mirror={}'; expected axes, such as mirror=x or mirror=xz",
                                    kOption, text));
    }
    axes[static_cast<size_t>(c - 'x')] = true;
  }
  return axes;
}

/// Takes one "key=value".
void take(std::string_view part, Placement& placement) {
  const std::vector<std::string> keys{"at", "rotate", "scale", "mirror"};
  const size_t equals = part.find('=');
  const std::string key(part.substr(0, equals));
  const std::string_view value = part.substr(equals + 1);
  if (key == "at") {
    placement.at = three_numbers(key, value);
  } else if (key == "rotate") {
    placement.rotate = three_numbers(key, value);
  } else if (key == "scale") {
    placement.scale = scale_of(value);
  } else if (key == "mirror") {
    placement.mirror = axes_of(value);
  } else {
    throw usage_error(fmt::format("{}: '{}'; expected at, rotate, scale or mirror{}", kOption, key,
                                  suggestion(key, keys)));
  }
}

void put(const std::array<double, 3>& from, v1::Vec3* to) {
  to->set_x(from[0]);
  to->set_y(from[1]);
  to->set_z(from[2]);
}

v1::Transform transform_of(const Placement& placement) {
  v1::Transform out;
  if (placement.at) put(*placement.at, out.add_steps()->mutable_translate());
  for (size_t axis = 0; placement.rotate && axis < 3; ++axis) {
    if ((*placement.rotate)[axis] == 0) continue;
    v1::AxisAngle& turn = *out.add_steps()->mutable_rotate();
    std::array<double, 3> along{};
    along[axis] = 1;
    put(along, turn.mutable_axis());
    turn.set_angle((*placement.rotate)[axis]);
  }
  std::array<double, 3> scale = placement.scale.value_or(std::array<double, 3>{1, 1, 1});
  for (size_t axis = 0; axis < 3; ++axis) {
    if (placement.mirror[axis]) scale[axis] = -scale[axis];
  }
  if (scale != std::array<double, 3>{1, 1, 1}) put(scale, out.add_steps()->mutable_scale());
  return out;
}

}  // namespace

v1::Include parse_placement(std::string_view text) {
  Placement placement;
  std::string_view file = text;
  // From the right, since names of files may hold colons too.
  for (size_t colon; (colon = file.rfind(':')) != std::string_view::npos;) {
    const std::string_view part = file.substr(colon + 1);
    if (part.find('=') == std::string_view::npos) break;
    take(part, placement);
    file = file.substr(0, colon);
  }
  v1::Include include;
  include.set_file(std::string(file));
  *include.mutable_transform() = transform_of(placement);
  return include;
}

void add_place_option(OptionList& list, std::vector<v1::Include>& placements) {
  OptionGroup(list, "Scene")
      .add(
          "--place", "FILE[:...]",
          "Place another scene or model into this one: FILE, then any of :at=X,Y,Z "
          ":rotate=X,Y,Z (degrees) :scale=S or X,Y,Z :mirror=AXES. Without FILE: the scene itself. "
          "May be given more than once",
          [&placements](const std::string& text) { placements.push_back(parse_placement(text)); })
      .repeats = true;
}

}  // namespace tessera
