#include <fmt/format.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>

#include <memory>

#include "base/digest.h"
#include "base/lower_case.h"
#include "python/errors.h"
#include "python/generate/named_things.h"
#include "python/value_reader.h"

// The part of ValueReader that puts materials, textures and objects where their names are wanted.

namespace py = pybind11;
namespace pb = google::protobuf;

namespace tessera {

const pb::FieldDescriptor* list_of(const pb::Descriptor* type) {
  for (const char* name : {"materials", "textures", "objects"}) {
    const pb::FieldDescriptor* list = v1::Scene::descriptor()->FindFieldByName(name);
    if (list->message_type() == type) return list;
  }
  return nullptr;
}

const pb::Descriptor* named_type(const pb::FieldDescriptor& field) {
  static auto* const known =
      new std::unordered_map<const pb::FieldDescriptor*, const pb::Descriptor*>;
  const auto [at, is_new] = known->try_emplace(&field);
  if (is_new) {
    const std::string& full = field.full_name();
    const std::string type = type_named_by(full.substr(field.file()->package().size() + 1));
    if (!type.empty()) at->second = field.file()->FindMessageTypeByName(type);
  }
  return at->second;
}

std::string describe_found(py::handle value) {
  const py::error_scope raised;  // what is being told of; the value's own code runs without it
  constexpr size_t kLongest = 60;
  std::string text = py::isinstance<py::str>(value) || py::isinstance<py::float_>(value) ||
                             py::isinstance<py::int_>(value) || value.is_none()
                         ? py::repr(value).cast<std::string>()
                         : with_article(Py_TYPE(value.ptr())->tp_name);
  if (text.size() <= kLongest) return text;
  size_t end = kLongest;
  while ((text[end] & 0xC0) == 0x80) --end;  // a character is left out as a whole
  return text.substr(0, end) + "...";
}

std::string bytes_of(const pb::Message& message) {
  std::string bytes;
  pb::io::StringOutputStream stream(&bytes);
  pb::io::CodedOutputStream coded(&stream);
  coded.SetSerializationDeterministic(true);
  message.SerializeToCodedStream(&coded);
  coded.Trim();
  return bytes;
}

std::string ValueReader::name_of(py::handle held, const Field& field) {
  const pb::Descriptor* type = named_type(field);
  const ValueClass* made = find_value_class(held);
  if (made && made->message == type) return collect(held, *made);
  if (type == v1::Texture::descriptor() && is_picture(held)) {
    const py::object texture = texture_of(held, field.name() == "normal_map");
    return collect(texture, *find_value_class(texture));
  }
  if (!PyUnicode_Check(held.ptr())) {
    fail(describe_found(held), with_article(type->name()) + " or the name of one");
  }
  return to_text(held);
}

std::string ValueReader::collect(py::handle thing, const ValueClass& made) {
  Collection& collection = collections_[made.message];
  const auto known = collection.name_of.find(thing.ptr());
  const py::object own_name = get_slot(made.field("name"), thing);
  if (known != collection.name_of.end()) {
    if (known->second.empty() && own_name.is_none())
      fail("it refers to itself", "a name, to do so", "NestingError");
    return known->second.empty() ? to_text(own_name) : known->second;
  }
  collection.name_of[thing.ptr()] = "";
  collected_.push_back(py::reinterpret_borrow<py::object>(thing));
  // The list's element is made at last, since what is read may add others.
  const std::unique_ptr<Message> message(
      pb::MessageFactory::generated_factory()->GetPrototype(made.message)->New());
  read(thing, *message);
  const pb::Reflection& of = *message->GetReflection();
  const Field* name_field = made.message->FindFieldByName("name");
  std::string name = of.GetString(*message, name_field);
  if (name.empty()) {
    constexpr size_t kDigits = 12;
    name = fmt::format("{} {}", lower_case(made.message->name()),
                       Digest::of(bytes_of(*message)).hex().substr(0, kDigits));
    of.SetString(message.get(), name_field, name);
  }
  std::string bytes = bytes_of(*message);
  collection.name_of[thing.ptr()] = name;
  const auto [named, is_new] = collection.by_name.try_emplace(name, bytes);
  if (!is_new && named->second != bytes) {
    fail(fmt::format("two {}s named '{}' that are not equal", lower_case(made.message->name()),
                     name),
         "each name once");
  }
  if (is_new) {
    const Field* list = list_of(made.message);
    scene_.GetReflection()->AddMessage(&scene_, list)->CopyFrom(*message);
    named_parts_.push_back({lower_case(made.message->name()), name, path_text(),
                            py::reinterpret_borrow<py::object>(thing)});
  }
  return name;
}

}  // namespace tessera
