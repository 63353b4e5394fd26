#include "scenes/import/origin_table.h"

#include <fmt/format.h>
#include <google/protobuf/unknown_field_set.h>

#include <utility>

#include "proto/wire/node_numbers.h"

namespace tessera {
namespace {

namespace pb = google::protobuf;

/// No field of scene.proto has this number.
constexpr int kField = 536870911;

/// Calls use(node, path) for a node and all below it.
template <typename Use>
void walk(v1::Node& node, const std::string& path, const Use& use) {
  use(node, path);
  if (node.shape().has_csg()) {
    int i = 0;
    for (v1::Node& operand : *node.mutable_shape()->mutable_csg()->mutable_operands())
      walk(operand, fmt::format("{}.shape.csg.operands[{}]", path, i++), use);
  }
  int i = 0;
  for (v1::Node& child : *node.mutable_children())
    walk(child, fmt::format("{}.children[{}]", path, i++), use);
}

}  // namespace

uint32_t origin_of(const pb::Message& message) {
  const pb::UnknownFieldSet& fields = message.GetReflection()->GetUnknownFields(message);
  for (int i = fields.field_count(); i-- > 0;) {
    const pb::UnknownField& field = fields.field(i);
    if (field.number() == kField && field.type() == pb::UnknownField::TYPE_VARINT)
      return static_cast<uint32_t>(field.varint());
  }
  return 0;
}

void set_origin(pb::Message& message, uint32_t number) {
  pb::UnknownFieldSet& fields = *message.GetReflection()->MutableUnknownFields(&message);
  fields.DeleteByNumber(kField);
  if (number != 0) fields.AddVarint(kField, number);
}

uint32_t OriginTable::file(const std::string& name) {
  const auto [at, is_new] = file_numbers_.try_emplace(name, static_cast<uint32_t>(files_.size()));
  if (is_new) files_.push_back(name);
  return at->second;
}

uint32_t OriginTable::add(Origin origin) {
  origins_.push_back(std::move(origin));
  return static_cast<uint32_t>(origins_.size());
}

void OriginTable::add_missing(v1::Scene& scene, const std::string& file_name, bool by_path) {
  const uint32_t number = file(file_name);
  const uint32_t whole = by_path ? 0 : add({.file = number});
  const auto mark = [&](pb::Message& message, const std::string& path) {
    if (origin_of(message) != 0) return;
    set_origin(message, by_path ? add({.file = number, .path = path}) : whole);
  };
  int i = 0;
  for (v1::Node& node : *scene.mutable_nodes()) walk(node, fmt::format("nodes[{}]", i++), mark);
  for (int k = 0; k < scene.objects_size(); ++k) {
    i = 0;
    for (v1::Node& node : *scene.mutable_objects(k)->mutable_nodes())
      walk(node, fmt::format("objects[{}].nodes[{}]", k, i++), mark);
  }
  for (i = 0; by_path && i < scene.includes_size(); ++i) {
    v1::Include& include = *scene.mutable_includes(i);
    mark(include, fmt::format("includes[{}]", i));
    origins_[origin_of(include) - 1].kind = Origin::Kind::include;
  }
}

void OriginTable::absorb(v1::Scene& scene, const OriginTable& of_scene) {
  if (of_scene.origins_.empty()) return;
  const auto before = static_cast<uint32_t>(origins_.size());
  for (Origin origin : of_scene.origins_) {
    origin.file = file(of_scene.files_[origin.file]);
    if (origin.above != 0) origin.above += before;
    add(std::move(origin));
  }
  for_each_node(scene, [before](v1::Node& node) {
    if (const uint32_t number = origin_of(node)) set_origin(node, before + number);
  });
}

void OriginTable::settle(v1::Scene& scene) {
  of_nodes_.clear();
  for_each_node(scene, [this](v1::Node& node) {
    of_nodes_.push_back(origin_of(node));
    if (of_nodes_.back() != 0) set_origin(node, 0);
  });
}

}  // namespace tessera
