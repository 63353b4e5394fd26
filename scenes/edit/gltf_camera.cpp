#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <span>
#include <utility>

#include "renderer/math/elementary.h"
#include "scenes/edit/camera_numbers.h"
#include "scenes/edit/edit_sequence.h"
#include "scenes/edit/gltf_edit.h"
#include "scenes/edit/language_placement.h"
#include "scenes/edit/literal.h"
#include "scenes/edit/message_edit.h"
#include "scenes/edit/message_outline.h"
#include "scenes/edit/message_writer.h"
#include "scenes/edit/x3d_rotation.h"
#include "scenes/import/unique_names.h"

namespace tessera::edit {
namespace {

constexpr size_t kMatrixNumbers = 16;  ///< column by column
constexpr double kSameAngle = 1e-8;    ///< radians

/// The values of a glTF document in the tree of its text, each by its syntax node; -1: none.
class GltfText {
 public:
  explicit GltfText(const Outline& outline) : text_(outline.text()), tree_(outline.tree()) {}

  /// The last member of that name, which is the one that counts; none for null.
  int32_t member(int32_t block, std::string_view name) const {
    int32_t found = -1;
    for (int32_t i = block < 0 ? -1 : tree_[block].first_child; i >= 0; i = tree_[i].next)
      if (text_of(text_, tree_[i].name) == name) found = i;
    return found >= 0 && literal(found) == "null" ? -1 : found;
  }
  std::vector<int32_t> items(int32_t list) const {
    std::vector<int32_t> found;
    if (list < 0 || tree_[list].kind != SyntaxKind::list) return found;
    for (int32_t i = tree_[list].first_child; i >= 0; i = tree_[i].next) found.push_back(i);
    return found;
  }
  std::optional<double> number(int32_t value) const {
    return value >= 0 ? typed_number(literal(value)) : std::nullopt;
  }
  /// Exactly so many numbers.
  std::optional<std::vector<double>> numbers(int32_t list, size_t count) const {
    const auto found = items(list);
    std::vector<double> made;
    for (const int32_t item : found)
      if (const auto each = number(item)) made.push_back(*each);
    if (found.size() != count || made.size() != count) return {};
    return made;
  }
  std::optional<size_t> index(int32_t value, size_t count) const {
    const auto at = number(value);
    if (!at || !(*at >= 0 && *at < static_cast<double>(count)) || *at != std::floor(*at)) return {};
    return static_cast<size_t>(*at);
  }
  std::string string(int32_t value) const {
    return value >= 0 && literal(value).starts_with('"') ? shown_value(text_, tree_, value) : "";
  }
  std::string_view literal(int32_t value) const { return text_of(text_, tree_[value].value); }
  const SyntaxNode& syntax(int32_t value) const { return tree_[value]; }

 private:
  std::string_view text_;
  const SyntaxTree& tree_;
};

/// Of a quaternion x y z w of any length.
Affine turn_of(std::span<const double> q) {
  const Vec3 axis{q[0], q[1], q[2]};
  return length(axis) > 0 ? rotation(axis, 2 * std::atan2(length(axis), q[3])) : Affine{};
}

/// The transform of a node; nothing where it has not the numbers that glTF wants.
std::optional<Affine> transform_of(const GltfText& gltf, int32_t node) {
  Affine made;
  if (const int32_t matrix = gltf.member(node, "matrix"); matrix >= 0) {
    const auto columns = gltf.numbers(matrix, kMatrixNumbers);
    if (!columns) return {};
    for (size_t i = 0; i < columns->size(); ++i)
      if (i % 4 < 3) made.m[i % 4][i / 4] = (*columns)[i];
    return made;
  }
  const auto read = [&](std::string_view name, std::vector<double> without) {
    const int32_t list = gltf.member(node, name);
    return list < 0 ? std::optional(without) : gltf.numbers(list, without.size());
  };
  const auto shift = read("translation", {0, 0, 0}), turn = read("rotation", {0, 0, 0, 1});
  const auto scale = read("scale", {1, 1, 1});
  if (!shift || !turn || !scale) return {};
  return translation({(*shift)[0], (*shift)[1], (*shift)[2]}) * turn_of(*turn) *
         scaling({(*scale)[0], (*scale)[1], (*scale)[2]});
}

/// A camera as the reader finds it in the scene that the file shows.
struct GltfCamera {
  int32_t node = -1, camera = -1;  ///< syntax
  size_t node_index = 0;
  std::string name;
  bool is_window = false;
  std::optional<Affine> above;  ///< of the nodes around its own; nothing: it cannot be read
};

/// Finds the cameras in the reader's order and under its names.
class GltfCameras {
 public:
  explicit GltfCameras(const Outline& outline) : gltf_(outline) {
    nodes_ = gltf_.items(gltf_.member(0, "nodes"));
    cameras_ = gltf_.items(gltf_.member(0, "cameras"));
    std::vector<std::pair<size_t, std::optional<Affine>>> open;
    const auto push = [&](const std::vector<size_t>& from, const std::optional<Affine>& above) {
      for (size_t i = from.size(); i-- > 0;) open.emplace_back(from[i], above);
    };
    std::vector<bool> seen(nodes_.size());
    for (push(roots(), Affine{}); !open.empty();) {
      const auto [node, above] = open.back();
      open.pop_back();
      if (seen[node]) continue;
      seen[node] = true;
      const auto own = transform_of(gltf_, nodes_[node]);
      const std::optional<Affine> world =
          above && own ? std::optional(*above * *own) : std::nullopt;
      if (world && !is_finite(*world)) continue;
      look_for_camera(node, above, world);
      push(children(gltf_.member(nodes_[node], "children")), world);
    }
  }

  const std::vector<GltfCamera>& all() const { return all_; }
  /// By its name or, as of `--camera`, its number from 1; empty: the first. Null: there is none.
  const GltfCamera* find(std::string_view name) const {
    if (name.empty()) return all_.empty() ? nullptr : &all_.front();
    for (const GltfCamera& each : all_)
      if (each.name == name) return &each;
    const double number = typed_number(name).value_or(0);
    for (size_t i = 0; i < all_.size(); ++i)
      if (static_cast<double>(i + 1) == number) return &all_[i];
    return nullptr;
  }
  /// Whether more than the camera moves with its node.
  bool holds_more(const GltfCamera& camera) const {
    const int32_t lights =
        gltf_.member(gltf_.member(camera.node, "extensions"), "KHR_lights_punctual");
    if (lights >= 0 || gltf_.member(camera.node, "mesh") >= 0 ||
        !gltf_.items(gltf_.member(camera.node, "children")).empty())
      return true;
    for (const int32_t skin : gltf_.items(gltf_.member(0, "skins")))
      for (const int32_t joint : gltf_.items(gltf_.member(skin, "joints")))
        if (gltf_.number(joint) == static_cast<double>(camera.node_index)) return true;
    return false;
  }

 private:
  std::vector<size_t> children(int32_t list) const {
    std::vector<size_t> made;
    for (const int32_t item : gltf_.items(list))
      if (const auto index = gltf_.index(item, nodes_.size())) made.push_back(*index);
    return made;
  }

  std::vector<size_t> roots() const {
    const auto scenes = gltf_.items(gltf_.member(0, "scenes"));
    if (!scenes.empty()) {
      const size_t shown = gltf_.index(gltf_.member(0, "scene"), scenes.size()).value_or(0);
      return children(gltf_.member(scenes[shown], "nodes"));
    }
    std::set<size_t> below;
    for (const int32_t node : nodes_)
      for (const size_t child : children(gltf_.member(node, "children"))) below.insert(child);
    std::vector<size_t> made;
    for (size_t i = 0; i < nodes_.size(); ++i)
      if (!below.contains(i)) made.push_back(i);
    if (made.empty() && !nodes_.empty()) made.push_back(0);
    return made;
  }

  void look_for_camera(size_t node, const std::optional<Affine>& above,
                       const std::optional<Affine>& world) {
    const auto index = gltf_.index(gltf_.member(nodes_[node], "camera"), cameras_.size());
    if (!index || (world && !is_invertible(*world))) return;
    const int32_t in = cameras_[*index];
    const std::string type = gltf_.string(gltf_.member(in, "type"));
    const int32_t values = gltf_.member(in, type);
    const auto is_size = [&](std::string_view name, double beyond) {
      const double size = std::abs(gltf_.number(gltf_.member(values, name)).value_or(0));
      return size > 0 && size < beyond;
    };
    constexpr double kEndless = std::numeric_limits<double>::infinity();
    const bool is_window = type == "orthographic";
    const bool is_seen = is_window ? is_size("xmag", kEndless) && is_size("ymag", kEndless)
                                   : type == "perspective" && is_size("yfov", portable::kPi);
    if (!is_seen) return;
    const std::string own = gltf_.string(gltf_.member(in, "name"));
    const std::string of_node = gltf_.string(gltf_.member(nodes_[node], "name"));
    all_.push_back({nodes_[node], in, node,
                    unique_(!own.empty()       ? own
                            : !of_node.empty() ? of_node
                                               : fmt::format("camera {}", *index)),
                    is_window, above});
  }

  GltfText gltf_;
  std::vector<int32_t> nodes_, cameras_;
  UniqueNames unique_;
  std::vector<GltfCamera> all_;
};

int entity_of(const Outline& outline, int32_t syntax) {
  for (size_t i = 1; i < outline.entities().size(); ++i)
    if (outline.entities()[i].syntax == static_cast<uint32_t>(syntax)) return static_cast<int>(i);
  return 0;
}

/// Gives the list `name` of the entity these numbers where they are others, an empty one standing
/// for what is there; makes the list where there is none.
Change set_numbers(const Outline& outline, int entity, std::string_view name,
                   const std::vector<std::string>& numbers) {
  const GltfText gltf(outline);
  const auto holder = static_cast<int32_t>(outline.entities()[static_cast<size_t>(entity)].syntax);
  const int32_t list = gltf.member(holder, name);
  Change change;
  if (list < 0) {
    const MessageWriter writer(outline);
    change.edits.push_back(
        writer.append(holder, writer.json_member(name, writer.json_list(numbers))));
    return change;
  }
  const auto items = gltf.items(list);
  for (size_t i = 0; i < numbers.size() && i < items.size(); ++i)
    if (!numbers[i].empty() && gltf.number(items[i]) != typed_number(numbers[i]))
      change.edits.push_back({gltf.syntax(items[i]).value, numbers[i]});
  return change;
}

/// The numbers with the fewest digits that `is_enough` accepts.
template <typename Enough>
std::vector<std::string> shortest(std::span<const double> numbers, const Enough& is_enough) {
  constexpr double kFiner = 8, kFinest = 1e-17;
  std::vector<std::string> texts(numbers.size());
  for (double tolerance = kSameRotation; tolerance > kFinest; tolerance /= kFiner) {
    std::vector<double> read(numbers.size());
    for (size_t i = 0; i < numbers.size(); ++i) {
      texts[i] = shortest_number(numbers[i], tolerance);
      read[i] = typed_number(texts[i]).value_or(numbers[i]);
    }
    if (is_enough(read)) break;
  }
  return texts;
}

/// The edits by which the node of a camera, whose transform can be read, is where the pose has it.
void place(EditSequence& sequence, int entity, const Affine& above, const CameraPose& pose) {
  const GltfText gltf(sequence.now());
  const auto node =
      static_cast<int32_t>(sequence.now().entities()[static_cast<size_t>(entity)].syntax);
  const Affine there = *transform_of(gltf, node);
  const bool is_matrix = gltf.member(node, "matrix") >= 0;
  const auto old_turn = gltf.numbers(gltf.member(node, "rotation"), 4);
  // The signs of the scale, which stays, turn the camera as well.
  Affine signs;
  const auto scale = gltf.numbers(gltf.member(node, "scale"), 3);
  for (size_t i = 0; scale && !is_matrix && i < 3; ++i)
    signs.m[i][i] = std::copysign(1.0, (*scale)[i]);
  const Affine wanted =
      look_at(Point3{} + to_vec(pose.eye), Point3{} + to_vec(pose.target), to_vec(pose.up));
  const auto is_wanted = [&](const Affine& own) {
    const Affine world = above * own * signs;
    return world.determinant() > 0 &&
           rotation_difference(wanted, seen_from(world)) <= kSameRotation;
  };
  // A rotation, whichever way the scale takes the axis to the right.
  const double sy = signs.m[1][1], sz = signs.m[2][2];
  const Affine turn = seen_from(inverse(above) * wanted) * scaling({sy * sz, sy, sz});
  const auto eye = written_eye(pose, above, {there.m[0][3], there.m[1][3], there.m[2][3]});
  const auto shift = eye ? typed_parts(*eye) : std::vector<std::string>(3);
  const auto set = [&](std::string_view name, const std::vector<std::string>& numbers) {
    sequence.then([&](const Outline& now) { return set_numbers(now, entity, name, numbers); });
  };
  if (is_matrix) {
    std::vector<double> columns;
    for (size_t i = 0; i < 9; ++i) columns.push_back(turn.m[i % 3][i / 3]);
    std::vector<std::string> texts(columns.size());
    if (!is_wanted(there)) {
      texts = shortest(columns, [&](const std::vector<double>& read) {
        Affine own;
        for (size_t i = 0; i < read.size(); ++i) own.m[i % 3][i / 3] = read[i];
        return is_wanted(own);
      });
    }
    texts.insert(texts.end(), shift.begin(), shift.end());
    for (size_t column = 0; column < 4; ++column)
      texts.insert(texts.begin() + static_cast<ptrdiff_t>(4 * column + 3), "");
    return set("matrix", texts);
  }
  if (eye) set("translation", shift);
  if (is_wanted(old_turn ? turn_of(*old_turn) : Affine{})) return;
  const auto [x, y, z, angle] = axis_angle(turn);
  const double sine = std::sin(angle / 2);
  const double quaternion[] = {x * sine, y * sine, z * sine, std::cos(angle / 2)};
  set("rotation", shortest(quaternion, [&](const auto& read) { return is_wanted(turn_of(read)); }));
}

/// The angle over the height, in radians; nothing where that depends on a shape of the picture
/// that is not known.
std::optional<double> vertical_angle(const CameraPose& pose) {
  const double angle = portable::radians(*pose.field_of_view);
  const bool is_vertical = pose.axis.empty() || pose.axis == "vertical";
  if (is_vertical || pose.aspect == 1) return angle;
  if (!(pose.aspect > 0)) return {};
  const bool is_high = pose.aspect < 1;
  if ((pose.axis == "smaller" && !is_high) || (pose.axis == "larger" && is_high)) return angle;
  return 2 * std::atan(std::tan(angle / 2) / pose.aspect);
}

/// Sets the projection of the camera whose entity that is.
void set_lens(EditSequence& sequence, int entity, const CameraPose& pose) {
  const auto set = [&](std::string_view name, double wanted) {
    sequence.then([&](const Outline& now) {
      const Entity& camera = now.entities()[static_cast<size_t>(entity)];
      const double there = std::abs(typed_number(written_text(camera, name)).value_or(0));
      if (std::abs(there - wanted) <= kSameAngle) return Change{};
      return set_gltf_field(now, entity, name, shortest_number(wanted, kSameAngle));
    });
  };
  if (pose.orthographic) {
    set("orthographic.xmag", *pose.orthographic / 2);
    set("orthographic.ymag", *pose.orthographic / 2);
  } else if (pose.field_of_view) {
    set("perspective.yfov", *vertical_angle(pose));
  }
}

/// Why the camera cannot be given the pose, whatever else the text has.
std::optional<Refusal> fault_of(const Outline& outline, const GltfCamera& camera) {
  const SourceRange range = outline.tree()[camera.node].range;
  const GltfText gltf(outline);
  if (!camera.above || !transform_of(gltf, camera.node))
    return Refusal{"a transform around the camera that cannot be read",
                   "16 numbers of a matrix, or 3, 4 and 3 of translation, rotation and scale",
                   range};
  const auto scale = gltf.numbers(gltf.member(camera.node, "scale"), 3);
  const bool is_mirrored = scale && gltf.member(camera.node, "matrix") < 0 &&
                           (*scale)[0] * (*scale)[1] * (*scale)[2] < 0;
  if ((camera.above->determinant() < 0) != is_mirrored)
    return Refusal{"a camera in a transform that mirrors, as its picture would be",
                   "one without an odd number of negative scales", range};
  return {};
}

Change set_camera(const Outline& outline, const GltfCameras& cameras, const GltfCamera& camera,
                  const CameraPose& pose) {
  if (const auto fault = fault_of(outline, camera))
    return refuse(fault->found, fault->expected, fault->range);
  const int node = entity_of(outline, camera.node), lens = entity_of(outline, camera.camera);
  EditSequence sequence(outline);
  sequence.keep(node);
  place(sequence, node, *camera.above, pose);
  const Change placed = sequence.finish();
  if (!placed.edits.empty() && cameras.holds_more(camera))
    return refuse("a camera whose node holds more, which would move with it",
                  "a node of the camera's own", outline.tree()[camera.node].range);
  set_lens(sequence, lens, pose);
  const Change made = sequence.finish();
  const auto sharing = std::ranges::count(cameras.all(), camera.camera, &GltfCamera::camera);
  if (sharing > 1 && made.edits != placed.edits)
    return refuse(fmt::format("another lens of a camera that {} nodes show", sharing),
                  "a camera of the node's own", outline.tree()[camera.camera].range);
  return made;
}

/// Adds `item` at the end of the list of that name in the block, and the list where there is none.
Change append_to(const Outline& outline, int32_t block, std::string_view name,
                 const std::string& item) {
  const int32_t list = GltfText(outline).member(block, name);
  const MessageWriter writer(outline);
  Change change;
  if (list < 0) {
    change.edits.push_back(
        writer.append(block, writer.json_member(name, writer.json_list({item}))));
  } else if (outline.tree()[list].kind == SyntaxKind::list) {
    change.edits.push_back(writer.append(list, item));
  } else {
    return refuse(fmt::format("'{}' that is no list", name), "a list", outline.tree()[list].range);
  }
  return change;
}

/// Adds a camera, and its node to the scene that the file shows.
Change add_camera(const Outline& outline, const CameraPose& pose) {
  EditSequence sequence(outline);
  const MessageWriter writer(outline);
  const auto count = [&](std::string_view name) {
    const GltfText gltf(sequence.now());
    return gltf.items(gltf.member(0, name)).size();
  };
  const size_t camera = count("cameras"), node = count("nodes"), scenes = count("scenes");
  const std::string lens = writer.json_block(
      {{"yfov", shortest_number(*vertical_angle(pose), kSameAngle)}, {"znear", "0.01"}});
  sequence.then([&](const Outline& now) {
    return append_to(now, 0, "cameras",
                     writer.json_block({{"type", "\"perspective\""}, {"perspective", lens}}));
  });
  sequence.then([&](const Outline& now) {
    return append_to(now, 0, "nodes", writer.json_block({{"camera", std::to_string(camera)}}));
  });
  if (scenes > 0)
    sequence.then([&](const Outline& now) {
      const GltfText gltf(now);
      const auto all = gltf.items(gltf.member(0, "scenes"));
      const size_t shown = gltf.index(gltf.member(0, "scene"), all.size()).value_or(0);
      return append_to(now, all[shown], "nodes", std::to_string(node));
    });
  sequence.then([&](const Outline& now) {
    const GltfText gltf(now);
    const auto nodes = gltf.items(gltf.member(0, "nodes"));
    const int entity = node < nodes.size() ? entity_of(now, nodes[node]) : 0;
    if (entity == 0) return refuse("a text with mistakes", "one whose parts stay what they are");
    sequence.keep(entity);
    EditSequence placing(now);
    placing.keep(entity);
    place(placing, entity, {}, pose);
    return placing.finish();
  });
  return sequence.finish();
}

}  // namespace

Change write_gltf_camera(const Outline& outline, std::string_view name, const CameraPose& pose) {
  if (pose.field_of_view && !pose.orthographic && !vertical_angle(pose))
    return refuse(fmt::format("a field of view over the {} axis", pose.axis),
                  "the vertical one, as glTF has it");
  const GltfCameras cameras(outline);
  const GltfCamera* const camera = cameras.find(name);
  if (!camera && !name.empty())
    return refuse(fmt::format("no camera '{}'", name), "a camera's name");
  const bool is_window = camera && camera->is_window;
  if (pose.orthographic && !is_window)
    return refuse("an orthographic camera", "a perspective one, as the text has it");
  if (!pose.orthographic && is_window)
    return refuse("a perspective camera", "an orthographic one, as the text has it");
  if (camera) return set_camera(outline, cameras, *camera, pose);
  CameraPose whole = pose;
  if (!whole.field_of_view) whole.field_of_view = 45;
  return add_camera(outline, whole);
}

}  // namespace tessera::edit
