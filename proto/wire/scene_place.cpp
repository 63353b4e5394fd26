#include "proto/wire/scene_place.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <functional>

#include "base/plain_text.h"
#include "proto/wire/scene_errors.h"

namespace tessera {
namespace {

namespace pb = google::protobuf;
using pb::FieldDescriptor;

/// "nodes[3]", of a field in another message: `path` with it.
std::string path_to(std::string path, const FieldDescriptor& field, int index) {
  if (!path.empty()) path += '.';
  path += field.name();
  if (field.is_repeated()) path += fmt::format("[{}]", index);
  return path;
}

/// A message of the scene, and its path from there: "nodes[3].shape".
struct Part {
  const pb::Message* message = nullptr;
  std::string path;
};

/// Finds what an error's words name: "node 'hall' > node 3 > shape: sphere.radius is -1". Names may
/// hold anything, so steps are recognised by what the scene has, not cut at their marks.
class Finder {
 public:
  explicit Finder(const v1::Scene& scene) : root_{&scene, ""} {}

  /// The path of that field; nothing where the scene has no such part, or several.
  std::optional<std::string> find(std::string_view message) {
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
        found_.push_back(path_of_field(next, rest.substr(2)));
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
                        path_to(part.path, *field, i)};
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
      step += fmt::format(" '{}'", escape_controls(name));
    } else if (index >= 0 && !text.substr(step.size()).starts_with(": ")) {
      // Cameras are not numbered; of several without a name none is found.
      step += fmt::format(" {}", index + 1);
    }
    if (text.starts_with(step)) visit(part, text.substr(step.size()));
  }

  static std::optional<Part> nested(const Part& part, const std::string& name) {
    const FieldDescriptor* field = part.message->GetDescriptor()->FindFieldByName(name);
    if (!field || field->is_repeated() || field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE ||
        !part.message->GetReflection()->HasField(*part.message, field)) {
      return std::nullopt;
    }
    return Part{&part.message->GetReflection()->GetMessage(*part.message, field),
                path_to(part.path, *field, 0)};
  }

  /// Of "sphere.radius" in "sphere.radius is -1", as deep as the scene has it.
  static std::string path_of_field(Part part, std::string_view text) {
    std::string_view path = text.substr(0, text.find(' '));
    if (const auto entry = path_of_entry(part, path, text)) return *entry;
    while (!path.empty()) {
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
      const auto inside = nested(part, name);
      if (!inside || dot == std::string_view::npos) return path_to(part.path, *field, 0);
      part = *inside;
      path.remove_prefix(dot + 1);
    }
    return part.path;
  }

  /// Of "material 'rde' is not defined": the entry of `materials`.
  static std::optional<std::string> path_of_entry(const Part& part, std::string_view kind,
                                                  std::string_view text) {
    const FieldDescriptor* field =
        part.message->GetDescriptor()->FindFieldByName(std::string(kind) + "s");
    if (!field || !field->is_repeated() || field->cpp_type() != FieldDescriptor::CPPTYPE_STRING) {
      return std::nullopt;
    }
    const pb::Reflection& reflection = *part.message->GetReflection();
    for (int i = 0; i < reflection.FieldSize(*part.message, field); ++i) {
      const std::string name = reflection.GetRepeatedString(*part.message, field, i);
      if (text.substr(kind.size()).starts_with(" '" + escape_controls(name) + "' ")) {
        return path_to(part.path, *field, i);
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
  std::vector<std::string> found_;
};

}  // namespace

std::optional<std::string> path_of_error(const v1::Scene& scene, std::string_view message) {
  return Finder(scene).find(message);
}

SourcePlace place_in_text(const std::string& file, std::string_view text, std::string_view path,
                          const pb::TextFormat::ParseInfoTree& places) {
  const pb::Descriptor* type = v1::Scene::descriptor();
  const pb::TextFormat::ParseInfoTree* inside = &places;
  pb::TextFormat::ParseLocation at;
  while (!path.empty() && type && inside) {
    const std::string_view step = path.substr(0, path.find('.'));
    path.remove_prefix(std::min(path.size(), step.size() + 1));
    const size_t open = std::min(step.find('['), step.size());
    const FieldDescriptor* field = type->FindFieldByName(std::string(step.substr(0, open)));
    int index = -1;
    if (open < step.size())
      std::from_chars(step.data() + open + 1, step.data() + step.size(), index);
    pb::TextFormat::ParseLocation here = inside->GetLocation(field, index);
    // Of values in one list the parser tells where the list is.
    for (int i = index - 1; here.line < 0 && i >= 0; --i) here = inside->GetLocation(field, i);
    if (here.line >= 0) at = here;
    inside = inside->GetTreeForNested(field, index);
    type = field->message_type();
  }
  if (at.line < 0) return {file};
  return place_of(file, text, offset_of(text, at.line, at.column));
}

}  // namespace tessera
