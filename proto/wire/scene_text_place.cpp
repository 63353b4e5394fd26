#include <fmt/format.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <google/protobuf/text_format.h>

#include <functional>

#include "base/file.h"
#include "proto/wire/scene_codec.h"
#include "proto/wire/scene_errors.h"

namespace tessera {
namespace {

namespace pb = google::protobuf;
using pb::FieldDescriptor;
using Places = pb::TextFormat::ParseInfoTree;

/// A message of the text, and where it begins.
struct Part {
  const pb::Message* message = nullptr;
  Places* places = nullptr;
  pb::TextFormat::ParseLocation at;
};

/// Finds what an error's path names: "node 'hall' > node 3 > shape: sphere.radius is -1". Names may
/// hold anything, so steps are recognised by what the scene has, not cut at their marks.
class Finder {
 public:
  explicit Finder(const Part& root) : root_(root) {}

  /// Nothing where the scene has no such part, or several.
  std::optional<pb::TextFormat::ParseLocation> find(std::string_view message) {
    descend(root_, message);
    if (found_.size() != 1 || steps_ > kMostSteps) return std::nullopt;
    return found_.front();
  }

 private:
  using Visit = std::function<void(const Part&, std::string_view)>;

  void descend(const Part& part, std::string_view text) {
    // Many parts of one name, inside each other, would be looked through for ever.
    if (found_.size() > 1 || ++steps_ > kMostSteps) return;
    for_each_step(part, text, [this](const Part& next, std::string_view rest) {
      if (rest.starts_with(" > ")) {
        descend(next, rest.substr(3));
      } else if (rest.starts_with(": ")) {
        found_.push_back(place_of_field(next, rest.substr(2)));
      }
    });
  }

  /// Every part inside `part` that `text` may begin with, and what follows it there.
  void for_each_step(const Part& part, std::string_view text, const Visit& visit) const {
    const pb::Descriptor& type = *part.message->GetDescriptor();
    const auto step_in = [&](const Part& from, const char* kind, const char* field) {
      for_each_of(from, text, kind, field, visit);
    };
    if (&type == v1::Scene::descriptor()) {
      for (const char* kind : {"node", "object", "material", "texture", "camera"}) {
        step_in(part, kind, (std::string(kind) + "s").c_str());
      }
      for (const char* kind : {"background", "fog", "settings"}) step_in(part, kind, kind);
    } else if (&type == v1::Node::descriptor()) {
      step_in(part, "node", "children");
      for (const char* kind : {"shape", "light"}) step_in(part, kind, kind);
      const auto& node = static_cast<const v1::Node&>(*part.message);
      if (!node.instance_of().empty()) step_in(root_, "object", "objects");
    } else if (&type == v1::Object::descriptor()) {
      step_in(part, "node", "nodes");
    } else if (&type == v1::Shape::descriptor()) {
      if (const auto csg = nested(part, "csg")) step_in(*csg, "operand", "operands");
    } else if (&type == v1::Csg::descriptor()) {
      step_in(part, "operand", "operands");
    }
  }

  void for_each_of(const Part& part, std::string_view text, std::string_view kind,
                   const char* field_name, const Visit& visit) const {
    if (!text.starts_with(kind)) return;
    const FieldDescriptor* field = part.message->GetDescriptor()->FindFieldByName(field_name);
    const pb::Reflection& reflection = *part.message->GetReflection();
    if (!field->is_repeated()) {
      const auto inside = nested(part, field_name);
      if (inside) match(*inside, text, std::string(kind), -1, visit);
      return;
    }
    const int count = reflection.FieldSize(*part.message, field);
    for (int i = 0; i < count; ++i) {
      const Part inside{&reflection.GetRepeatedMessage(*part.message, field, i),
                        part.places->GetTreeForNested(field, i),
                        part.places->GetLocation(field, i)};
      match(inside, text, std::string(kind), i, visit);
    }
  }

  /// As Where::str() spells it.
  static void match(const Part& part, std::string_view text, std::string step, int index,
                    const Visit& visit) {
    const FieldDescriptor* field = part.message->GetDescriptor()->FindFieldByName("name");
    const std::string name =
        field ? part.message->GetReflection()->GetString(*part.message, field) : "";
    if (!name.empty()) {
      step += fmt::format(" '{}'", name);
    } else if (index >= 0 && !text.substr(step.size()).starts_with(": ")) {
      // Cameras are not numbered; of several without a name none is found.
      step += fmt::format(" {}", index + 1);
    }
    if (part.places && text.starts_with(step)) visit(part, text.substr(step.size()));
  }

  static std::optional<Part> nested(const Part& part, const std::string& name) {
    const FieldDescriptor* field = part.message->GetDescriptor()->FindFieldByName(name);
    if (!field || field->is_repeated() || field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE ||
        !part.message->GetReflection()->HasField(*part.message, field)) {
      return std::nullopt;
    }
    return Part{&part.message->GetReflection()->GetMessage(*part.message, field),
                part.places->GetTreeForNested(field, -1), part.places->GetLocation(field, -1)};
  }

  /// Of "sphere.radius" in "sphere.radius is -1", as deep as the text writes it.
  static pb::TextFormat::ParseLocation place_of_field(Part part, std::string_view text) {
    std::string_view path = text.substr(0, text.find(' '));
    if (const auto entry = place_of_entry(part, path, text)) return *entry;
    while (!path.empty() && part.places) {
      const size_t dot = path.find('.');
      const std::string name(path.substr(0, dot));
      const FieldDescriptor* field = part.message->GetDescriptor()->FindFieldByName(name);
      if (!field) {
        // A kind's own fields are named without it: "shininess" of classic { shininess: -1 }.
        const auto inside = chosen_kind(part);
        if (!inside) break;
        part = *inside;
        continue;
      }
      const pb::TextFormat::ParseLocation at =
          part.places->GetLocation(field, field->is_repeated() ? 0 : -1);
      if (at.line >= 0) part.at = at;
      const auto inside = nested(part, name);
      if (!inside || dot == std::string_view::npos) break;
      part = *inside;
      path.remove_prefix(dot + 1);
    }
    return part.at;
  }

  /// Of "material 'rde' is not defined": the entry of `materials`.
  static std::optional<pb::TextFormat::ParseLocation> place_of_entry(const Part& part,
                                                                     std::string_view kind,
                                                                     std::string_view text) {
    const FieldDescriptor* field =
        part.message->GetDescriptor()->FindFieldByName(std::string(kind) + "s");
    if (!field || !field->is_repeated() || field->cpp_type() != FieldDescriptor::CPPTYPE_STRING) {
      return std::nullopt;
    }
    const pb::Reflection& reflection = *part.message->GetReflection();
    for (int i = 0; i < reflection.FieldSize(*part.message, field); ++i) {
      const std::string name = reflection.GetRepeatedString(*part.message, field, i);
      if (text.substr(kind.size()).starts_with(" '" + name + "' ")) {
        return part.places->GetLocation(field, i);
      }
    }
    return std::nullopt;
  }

  static std::optional<Part> chosen_kind(const Part& part) {
    const pb::OneofDescriptor* kinds = part.message->GetDescriptor()->FindOneofByName("kind");
    if (!kinds) return std::nullopt;
    const FieldDescriptor* chosen =
        part.message->GetReflection()->GetOneofFieldDescriptor(*part.message, kinds);
    return chosen ? nested(part, chosen->name()) : std::nullopt;
  }

  static constexpr int kMostSteps = 100000;

  Part root_;
  int steps_ = 0;
  std::vector<pb::TextFormat::ParseLocation> found_;
};

}  // namespace

SourcePlace place_in_scene_file(const std::string& path, std::string_view message) {
  if (scene_encoding_of(path) != SceneEncoding::text) return {path};
  std::string file;
  try {
    file = read_input_file(path, kMaxSceneFileBytes);
  } catch (const Error&) {  // it has changed since it was read
    return {path};
  }
  const std::string_view text = skip_byte_order_mark(file);
  Places places;
  pb::TextFormat::Parser parser;
  TextErrors ignored(path, text);
  parser.RecordErrorsTo(&ignored);
  parser.WriteLocationsTo(&places);
  parser.SetRecursionLimit(kMaxSceneDepth + 32);  // as it was read
  pb::io::ArrayInputStream input(text.data(), static_cast<int>(text.size()));
  v1::Scene scene;
  if (!parser.Parse(&input, &scene)) return {path};
  const auto at = Finder({&scene, &places, {}}).find(message);
  if (!at || at->line < 0) return {path};
  return place_of(path, text, offset_of(text, at->line, at->column));
}

}  // namespace tessera
