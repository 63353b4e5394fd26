#include <fmt/format.h>

#include <array>

#include "proto/wire/scene_codec.h"
#include "scenes/formats/x3d/document/x3d_nodes.h"
#include "scenes/formats/x3d/x3d_steps.h"
#include "scenes/formats/x3d/x3d_translator.h"
#include "scenes/import/to_affine.h"

namespace tessera {
namespace {

bool is_group(std::string_view type) {
  constexpr std::array<std::string_view, 14> kGroups{
      "Transform",  "Group",        "StaticGroup", "Collision",     "Anchor",
      "Switch",     "LOD",          "Billboard",   "Inline",        "HAnimHumanoid",
      "HAnimJoint", "HAnimSegment", "HAnimSite",   "ViewpointGroup"};
  return std::find(kGroups.begin(), kGroups.end(), type) != kGroups.end();
}

/// Whether what stands in that field of a group is shown where the group is.
bool is_shown(std::string_view field) {
  return field == "children" || field == "skeleton" || field == "skin";
}

/// Whether the field is of type SFNode.
bool holds_one_node(const X3dNodeType& type, std::string_view field) {
  return type.use == X3dNodeType::Use::read && !type.name.starts_with("Multi") &&
         !type.name.starts_with("HAnim") && field != "children" && field != "shaders" &&
         field != "attrib";
}

bool is_viewpoint(std::string_view type) { return type == "Viewpoint" || type == "OrthoViewpoint"; }

bool is_light(std::string_view type) {
  return type == "DirectionalLight" || type == "PointLight" || type == "SpotLight";
}

}  // namespace

std::string X3dBuild::unique(X3dNames& names, const std::string& wish) {
  int& number = names.next.try_emplace(wish, 2).first->second;
  std::string name = wish;
  while (!names.taken.insert(name).second) name = fmt::format("{}_{}", wish, number++);
  return name;
}

void X3dTranslator::add_all(const v1::Transform& path, double unit, Nodes& out) {
  check_names();
  const double scale = document_.metres_per_unit() / unit;
  if (scale == 1) {
    add_children(document_.scene(), path, out);
  } else {
    v1::Node& scaled = *out.Add();
    put_vec3(Vec3{1, 1, 1} * scale, scaled.mutable_transform()->add_steps()->mutable_scale());
    v1::Transform inner = path;
    inner.MergeFrom(scaled.transform());
    add_children(document_.scene(), inner, *scaled.mutable_children());
  }
  failures_.throw_if_any();
  list_ignored();
  values_.tell_remarks();
  warnings_.add_to(out_, document_.name());
}

void X3dTranslator::finish() {
  finish_cameras();
  set_settings();
  set_metadata();
}

void X3dTranslator::warn_unknown_field(size_t offset, const X3dNode& node, const X3dNodeType& type,
                                       const std::string& name) {
  values_.warn(offset, fmt::format("unknown field '{}' of {} is left out{}", name, node.type,
                                   suggestion(name, type.field_names())));
}

/// Says of every node and field that we do not know that it is left out.
void X3dTranslator::check_names() {
  // Once a name, and only while the list of warnings takes more: finding the nearest takes time.
  std::map<std::string_view, std::string> unknown;
  for (const X3dNode& node : document_.nodes()) {
    const bool is_scene = &node == &document_.scene();
    const X3dNodeType* type = find_x3d_node_type(is_scene ? "Group" : node.type);
    if (!type) {
      std::string& warning = unknown[node.type];
      if (warning.empty()) {
        const bool listed = unknown.size() <= Warnings::kMostEntries;
        warning = fmt::format("unknown node '{}' is left out{}", node.type,
                              listed ? suggestion(node.type, x3d_node_names()) : "");
      }
      values_.warn(node.offset, warning);
      continue;
    }
    for (const X3dField& field : node.fields) {
      if (type->has_field(field.name)) continue;
      if (!type->has_node_field(field.name))
        warn_unknown_field(field.offset, node, *type, field.name);
      else if (!field.text.empty() && field.text != "NULL")
        values_.repair(node, field.name, "a node", "it is left out");
    }
    std::set<std::string_view> single;
    for (const X3dNode::Child& child : node.children) {
      if (!find_x3d_node_type(child.node->type)) continue;  // told where it stands, whatever field
      if (!type->has_node_field(child.container) && type->has_field(child.container))
        values_.repair(node, child.container, child.node->offset, describe(*child.node), "a value",
                       "it is left out");
      else if (!type->has_node_field(child.container))
        warn_unknown_field(child.node->offset, node, *type, child.container);
      if (holds_one_node(*type, child.container) && !single.insert(child.container).second)
        values_.repair(node, child.container, child.node->offset, "a second node", "one",
                       "the last one is taken");
    }
  }
}

void X3dTranslator::list_ignored() {
  std::map<std::string, int> counts;
  for (const X3dNode& node : document_.nodes()) {
    const X3dNodeType* type = find_x3d_node_type(node.type);
    if (type && type->use == X3dNodeType::Use::ignored) ++counts[node.type];
  }
  std::string list;
  for (const auto& [type, count] : counts)
    list += fmt::format("{}{} {}", list.empty() ? "" : ", ", count, type);
  if (!list.empty()) warnings_.add("ignored: " + list);
}

std::vector<const X3dNode*> X3dTranslator::shown_children(const X3dNode& parent) const {
  // What is shown of a Switch and a LOD is one child; a Collision's proxy is never shown.
  int64_t only = -1;
  if (parent.type == "Switch") only = values_.integer(parent, "whichChoice", -1);
  if (parent.type == "LOD") only = 0;
  const bool selects = parent.type == "Switch" || parent.type == "LOD";
  int64_t number = 0;
  std::vector<const X3dNode*> shown;
  for (const X3dNode::Child& child : parent.children) {
    if (!is_shown(child.container)) continue;
    if (!selects || number++ == only) shown.push_back(child.node);
  }
  return shown;
}

void X3dTranslator::add_children(const X3dNode& parent, const v1::Transform& path, Nodes& out) {
  const int depth = build_.depth;
  for (const X3dNode* child : shown_children(parent)) {
    if (failures_.has_more()) return;
    try {
      add_node(*child, path, out);
    } catch (const Error& error) {
      // One is enough to leave out a file that is placed, and a circle of files is one fault.
      const bool is_placed = build_.files.open.size() > 1;
      if (is_placed || build_.files.is_endless || error.code() != ExitCode::bad_scene) throw;
      failures_.add(error);
      build_.depth = depth;
    }
  }
}

/// As add_children goes, but into no Inline.
bool X3dTranslator::find_view(const X3dNode& parent, const v1::Transform& path, int depth,
                              v1::Camera& out) {
  if (depth > X3dBuild::kMaxDepth || !without_view_.insert(&parent).second) return false;
  for (const X3dNode* child : shown_children(parent)) {
    if (is_viewpoint(child->type)) {
      const auto made = make_camera(*child, path);
      if (made) out = *made;
      if (made) return true;
    }
    if (!is_group(child->type)) continue;
    v1::Transform inner = path;
    if (has_x3d_transform(child->type)) inner.MergeFrom(transform(*child));
    if (find_view(*child, inner, depth + 1, out)) return true;
  }
  return false;
}

v1::Transform X3dTranslator::path_of_file() const {
  v1::Transform path;
  if (document_.metres_per_unit() != 1)
    put_vec3(Vec3{1, 1, 1} * document_.metres_per_unit(), path.add_steps()->mutable_scale());
  return path;
}

v1::Camera X3dTranslator::first_view() {
  v1::Camera out;
  return find_view(document_.scene(), path_of_file(), 0, out) ? out : default_camera();
}

double X3dTranslator::rough_extent() {
  const bool has_lines = std::ranges::any_of(
      document_.nodes(), [](const X3dNode& node) { return is_x3d_lines(node.type); });
  if (!has_lines) return 0;
  std::set<const X3dNode*> seen;
  Bounds3 all;
  add_points(document_.scene(), path_of_file(), 0, seen, all);
  return Pen::extent_of(all);
}

void X3dTranslator::add_points(const X3dNode& parent, const v1::Transform& path, int depth,
                               std::set<const X3dNode*>& seen, Bounds3& out) const {
  if (depth > X3dBuild::kMaxDepth || !seen.insert(&parent).second) return;
  for (const X3dNode* child : shown_children(parent)) {
    if (is_group(child->type)) {
      v1::Transform inner = path;
      if (has_x3d_transform(child->type)) inner.MergeFrom(transform(*child));
      add_points(*child, inner, depth + 1, seen, out);
    }
    if (child->type != "Shape") continue;
    const X3dNode* const geometry = child->child("geometry");
    const X3dNode* const coord = geometry ? geometry->child("coord") : nullptr;
    // What has sizes of its own is about as large as nodes are by default.
    const std::vector<float> numbers =
        coord ? values_.points(*coord) : std::vector<float>{-1, -1, -1, 1, 1, 1};
    const Affine to_world = to_affine(path);
    for (size_t i = 0; i + 2 < numbers.size(); i += 3) {
      const Point3 at = to_world(Point3{numbers[i], numbers[i + 1], numbers[i + 2]});
      if (is_finite(at - Point3{})) out.extend(at);
    }
  }
}

void X3dTranslator::add_node(const X3dNode& node, const v1::Transform& path, Nodes& out) {
  if (is_group(node.type) || node.type == "Shape") {
    // A scene's messages stand one inside the other up to kMaxSceneDepth; in an object they begin
    // anew.
    constexpr int kObjectLevels = kMaxSceneDepth / 2;
    const bool is_deep = build_.depth % kObjectLevels == kObjectLevels - 1;
    if (node.uses > 1 || is_deep) return add_instance(node, path, out);
    return fill_node(node, path, *out.Add());
  }
  if (is_light(node.type)) return add_light(node, out);
  if (is_viewpoint(node.type)) return add_camera(node, path);
  // Of the nodes that can be bound, the first one of its kind is.
  const bool is_background = node.type == "Background" || node.type == "TextureBackground";
  if (is_background && !out_.scene.has_background()) set_background(node, path);
  if (node.type == "Fog" && !build_.has_fog) set_fog(node, path);
  if (node.type == "NavigationInfo" && !build_.has_navigation) {
    build_.has_navigation = true;
    build_.headlight = values_.boolean(node, "headlight", true);
  }
  const X3dNodeType* type = find_x3d_node_type(node.type);
  if (type && type->use == X3dNodeType::Use::read && type->container != "children")
    values_.repair(node.offset, fmt::format("{} among children", describe(node)),
                   "a Shape, a group, a light or a viewpoint", "it is left out");
}

void X3dTranslator::add_instance(const X3dNode& node, const v1::Transform& path, Nodes& out) {
  auto known = objects_.find(&node);
  if (known == objects_.end()) {
    const std::string name =
        build_.unique(build_.object_names, node.def.empty() ? node.type : node.def);
    known = objects_.emplace(&node, name).first;
    v1::Object object;
    object.set_name(name);
    ++build_.depth;
    fill_node(node, path, *object.add_nodes());
    --build_.depth;
    *out_.scene.add_objects() = std::move(object);
  }
  out.Add()->set_instance_of(known->second);
}

void X3dTranslator::fill_node(const X3dNode& node, const v1::Transform& path, v1::Node& out) {
  if (build_.depth >= X3dBuild::kMaxDepth)
    throw document_.error(node.offset, "groups nested too deep",
                          fmt::format("at most {} levels", X3dBuild::kMaxDepth));
  out.set_name(node.def);
  mark(node, out);
  if (!values_.boolean(node, "visible", true)) out.set_hidden(true);
  if (node.type == "Shape") return add_shape(node, path, out);
  v1::Transform inner = path;
  if (has_x3d_transform(node.type)) {
    *out.mutable_transform() = transform(node);
    inner.MergeFrom(out.transform());
  }
  if (node.type == "Billboard")
    put_vec3(values_.vec3(node, "axisOfRotation", {0, 1, 0}), out.mutable_billboard_axis());
  ++build_.depth;
  if (node.type == "Inline")
    add_inline(node, inner, out);
  else
    add_children(node, inner, *out.mutable_children());
  --build_.depth;
}

void X3dTranslator::mark(const X3dNode& node, v1::Node& out) {
  if (!build_.options.origins) return;
  OriginTable& origins = out_.origins;
  Origin origin{.kind = node.type == "Inline" ? Origin::Kind::include : Origin::Kind::part,
                .file = origins.file(document_.name()),
                .offset = static_cast<uint32_t>(node.offset)};
  if (node.instance && !node.file) {
    origin.above = origins.add({.kind = Origin::Kind::use,
                                .file = origin.file,
                                .offset = static_cast<uint32_t>(*node.instance)});
  }
  set_origin(out, origins.add(std::move(origin)));
}

/// T C R SR S -SR -C, leaving out what does nothing.
v1::Transform X3dTranslator::transform(const X3dNode& node) const {
  const Vec3 center = values_.vec3(node, "center", {});
  const Vec3 scale = values_.vec3(node, "scale", {1, 1, 1});
  const X3dRotation turn = values_.rotation(node, "rotation");
  const X3dRotation scale_turn = values_.rotation(node, "scaleOrientation");
  const bool scales = !(scale == Vec3{1, 1, 1});
  const bool moves_center = !(center == Vec3{}) && (turn.angle != 0 || scales);
  v1::Transform out;
  add_translation(values_.vec3(node, "translation", {}), out);
  if (moves_center) add_translation(center, out);
  add_rotation(turn, out);
  if (scales) {
    add_rotation(scale_turn, out);
    put_vec3(scale, out.add_steps()->mutable_scale());
    add_rotation({scale_turn.axis, -scale_turn.angle}, out);
  }
  if (moves_center) add_translation(-center, out);
  return out;
}

}  // namespace tessera
