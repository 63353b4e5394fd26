#include "scenes/formats/scene_summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "base/error.h"
#include "scenes/import/message_walk.h"

namespace tessera {
namespace {

namespace pb = google::protobuf;

/// What is defined under a name, of one kind, and what refers to it.
struct Names {
  std::vector<std::string> defined;
  std::set<std::string> used;
};

class Summarizer {
 public:
  SceneSummary summarize(const v1::Scene& scene, const BlobStore& blobs) {
    for (const v1::Material& m : scene.materials()) materials_.defined.push_back(m.name());
    for (const v1::Texture& t : scene.textures()) textures_.defined.push_back(t.name());
    for (const v1::Object& o : scene.objects()) objects_.defined.push_back(o.name());
    // Every message once; what an object holds counts once however often it is placed.
    walk_message(
        scene, [this](const pb::Message& message) { visit(message); },
        [this](const pb::FieldDescriptor& field, const std::string& name) { refer(field, name); });
    add("cameras", scene.cameras_size());
    for (const auto& [what, number] : counts_) add(what, number);
    add("materials", scene.materials_size());
    add("textures", scene.textures_size());
    add("objects", scene.objects_size());
    uint64_t bytes = 0;
    for (const auto& [digest, data] : blobs.all()) bytes += data->size();
    add("blobs", blobs.size());
    add("blob bytes", bytes);
    compare("material", materials_);
    compare("texture", textures_);
    compare("object", objects_);
    return std::move(out_);
  }

 private:
  void add(const std::string& what, uint64_t number) {
    if (number > 0) out_.counts.push_back({what, number});
  }

  void compare(const char* kind, const Names& names) {
    std::set<std::string> defined(names.defined.begin(), names.defined.end());
    for (const std::string& name : names.defined)
      if (!names.used.contains(name)) out_.unused.push_back(fmt::format("{} '{}'", kind, name));
    for (const std::string& name : names.used)
      if (!defined.contains(name))
        out_.undefined.push_back(
            fmt::format("{} '{}'{}", kind, name, suggestion(name, names.defined)));
  }

  void refer(const pb::FieldDescriptor& field, const std::string& name) {
    if (name.empty()) return;
    if (field.name() == "materials" || field.name() == "back") {
      if (field.containing_type() != v1::Background::Cube::descriptor()) {
        materials_.used.insert(name);
        return;
      }
    }
    if (field.name() == "instance_of") objects_.used.insert(name);
    if (field.name() == "texture" || field.name() == "normal_map" ||
        field.containing_type() == v1::Background::Cube::descriptor())
      textures_.used.insert(name);
  }

  void visit(const pb::Message& message) {
    if (const auto* node = dynamic_cast<const v1::Node*>(&message)) {
      ++counts_["nodes"];
      if (!node->instance_of().empty()) ++counts_["instances"];
    } else if (const auto* light = dynamic_cast<const v1::Light*>(&message)) {
      static const std::map<int, const char*> kKinds{{v1::Light::kDirectional, "directional"},
                                                     {v1::Light::kPoint, "point"},
                                                     {v1::Light::kSpot, "spot"},
                                                     {v1::Light::kCylinder, "cylinder"}};
      const auto kind = kKinds.find(light->kind_case());
      if (kind != kKinds.end()) ++counts_[fmt::format("lights, {}", kind->second)];
    } else if (const auto* shape = dynamic_cast<const v1::Shape*>(&message)) {
      const auto* kind = v1::Shape::descriptor()->FindFieldByNumber(shape->kind_case());
      if (kind) ++counts_[fmt::format("shapes, {}", kind->name())];
    } else if (const auto* mesh = dynamic_cast<const v1::TriangleMesh*>(&message)) {
      counts_["triangles"] +=
          mesh->triangles().size() / 12 + static_cast<uint64_t>(mesh->inline_triangles_size()) / 3;
      counts_["vertices"] +=
          mesh->positions().size() / 12 + static_cast<uint64_t>(mesh->inline_positions_size()) / 3;
    }
  }

  SceneSummary out_;
  Names materials_, textures_, objects_;
  std::map<std::string, uint64_t> counts_;
};

}  // namespace

SceneSummary summarize(const v1::Scene& scene, const BlobStore& blobs) {
  return Summarizer().summarize(scene, blobs);
}

}  // namespace tessera
