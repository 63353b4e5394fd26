#include "python/value_writer.h"

#include <fmt/format.h>

#include <map>

#include "base/error.h"
#include "proto/tessera/v1/scene.pb.h"
#include "python/generate/enum_names.h"
#include "python/gil.h"
#include "python/mesh_arrays.h"
#include "python/value_classes.h"

namespace py = pybind11;
namespace pb = google::protobuf;

namespace tessera {
namespace {

class ValueWriter {
 public:
  explicit ValueWriter(const BlobStore& blobs) : blobs_(blobs) {}

  py::object write(const pb::Message& message) {
    pause_();
    const ValueClass& made = value_class_of(message);
    const pb::Message& kind =
        made.kind ? message.GetReflection()->GetMessage(message, made.kind) : message;
    const py::object value = made.made.attr("__new__")(made.made);
    for (const ValueField& field : made.fields) {
      const pb::Message& from = field.of_kind ? kind : message;
      set_slot(field, value, field.field ? write_field(from, *field.field) : py::none());
    }
    return value;
  }

 private:
  py::object write_field(const pb::Message& from, const pb::FieldDescriptor& field) {
    const pb::Reflection& of = *from.GetReflection();
    if (field.is_map()) return write_map(from);
    if (field.is_repeated()) {
      const int count = of.FieldSize(from, &field);
      py::list list(count);
      for (int i = 0; i < count; ++i) list[i] = write_one(from, field, i);
      return list;
    }
    return of.HasField(from, &field) ? write_one(from, field, -1) : py::none();
  }

  static py::object write_map(const pb::Message& from) {
    py::dict dict;
    // In an order of its own: that of the map is not the same in each process.
    const auto& map = static_cast<const v1::Metadata&>(from).properties();
    const std::map<std::string, std::string> sorted(map.begin(), map.end());
    for (const auto& [key, value] : sorted) dict[py::str(key)] = py::str(value);
    return dict;
  }

  /// Element `at` of a repeated field, or the field itself.
  py::object write_one(const pb::Message& from, const pb::FieldDescriptor& field, int at) {
    using Field = pb::FieldDescriptor;
    const pb::Reflection& of = *from.GetReflection();
    const bool many = at >= 0;
    switch (field.cpp_type()) {
      case Field::CPPTYPE_DOUBLE:
        return py::float_(many ? of.GetRepeatedDouble(from, &field, at)
                               : of.GetDouble(from, &field));
      case Field::CPPTYPE_FLOAT:
        return py::float_(many ? of.GetRepeatedFloat(from, &field, at) : of.GetFloat(from, &field));
      case Field::CPPTYPE_BOOL:
        return py::bool_(of.GetBool(from, &field));
      case Field::CPPTYPE_INT32:
        return py::int_(of.GetInt32(from, &field));
      case Field::CPPTYPE_UINT32:
        return py::int_(many ? of.GetRepeatedUInt32(from, &field, at) : of.GetUInt32(from, &field));
      case Field::CPPTYPE_ENUM:
        return py::str(python_name(*of.GetEnum(from, &field)));
      case Field::CPPTYPE_STRING:
        return py::str(many ? of.GetRepeatedString(from, &field, at) : of.GetString(from, &field));
      default:
        return write_message(
            from, many ? of.GetRepeatedMessage(from, &field, at) : of.GetMessage(from, &field),
            field);
    }
  }

  py::object write_message(const pb::Message& owner, const pb::Message& message,
                           const pb::FieldDescriptor& field) {
    const pb::Descriptor* type = message.GetDescriptor();
    if (type == v1::Vec3::descriptor()) {
      const auto& vector = static_cast<const v1::Vec3&>(message);
      return vec_(vector.x(), vector.y(), vector.z());
    }
    if (type == v1::Color::descriptor()) {
      const auto& color = static_cast<const v1::Color&>(message);
      return run_or_sleep([&] { return color_(color.r(), color.g(), color.b()); });
    }
    if (type == v1::ColorInput::descriptor()) {
      const auto& input = static_cast<const v1::ColorInput&>(message);
      const bool is_plain = input.has_value() && input.texture().empty();
      return is_plain ? write_message(input, input.value(), field) : write(message);
    }
    if (type == v1::FloatInput::descriptor()) {
      const auto& input = static_cast<const v1::FloatInput&>(message);
      const bool is_plain = input.has_value() && input.texture().empty() && input.channel() == 0;
      return is_plain ? py::float_(input.value()) : write(message);
    }
    if (type == v1::BlobRef::descriptor()) {
      return write_array(owner, static_cast<const v1::BlobRef&>(message), field.name());
    }
    return write(message);
  }

  py::object write_array(const pb::Message& owner, const v1::BlobRef& ref,
                         const std::string& field) {
    const BlobData blob = blobs_.find(Digest::from_hex(ref.digest()));
    if (!blob) throw scene_error(fmt::format("{}: there is no blob {}", field, ref.digest()));
    auto [type, columns] = blob_layout(field);
    Array::Shape shape = {0};
    if (field == "texels") {
      const auto& image = static_cast<const v1::Texture::Image&>(owner);
      type = texel_type(image.bits());
      shape = {image.height(), image.width(), image.channels()};
    }
    const auto count = static_cast<py::ssize_t>(blob->size()) / type.size;
    if (columns > 0) shape = {count / columns, columns};
    py::ssize_t expected = 1;
    for (const py::ssize_t length : shape) expected *= length;
    // Textures with several levels, and what does not come out even, are one row of numbers.
    if (expected != count) shape = {count};
    return py::cast(array_of_blob(blob, type, std::move(shape)));
  }

  const BlobStore& blobs_;
  GilPauses pause_;
  py::object vec_ = py::module_::import("tessera._core").attr("Vec");
  py::object color_ = py::module_::import("tessera._colors").attr("Color");
};

}  // namespace

py::object write_value(const pb::Message& message, const BlobStore& blobs) {
  return ValueWriter(blobs).write(message);
}

}  // namespace tessera
