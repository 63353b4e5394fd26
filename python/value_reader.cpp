#include "python/value_reader.h"

#include <fmt/format.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/digest.h"
#include "proto/wire/scene_codec.h"
#include "python/array_source.h"
#include "python/errors.h"
#include "python/generate/enum_names.h"
#include "python/gil.h"
#include "python/mesh_arrays.h"

namespace py = pybind11;
namespace pb = google::protobuf;

namespace tessera {

std::pair<std::string, std::string> nested_too_deep() {
  return {"something inside itself, or nested too deep",
          fmt::format("at most {} levels", kMaxSceneDepth)};
}

namespace {

/// Looked up once for all values.
struct Parts {
  py::object errors = py::module_::import("tessera.errors");
  py::object color = py::module_::import("tessera._colors").attr("color");
  py::object texture_from = py::module_::import("tessera._textures").attr("texture_from");
  py::object normals_from = py::module_::import("tessera._textures").attr("normals_from");
  py::object instances = py::module_::import("tessera._graph").attr("Instances");
};

const Parts& parts() {
  static const auto* const found = new Parts;
  return *found;
}

/// What function(argument) returns. Holds no reference that the end of a daemon thread would drop.
py::object call_python(py::handle function, py::handle argument) {
  PyObject* const made =
      run_or_sleep([&] { return PyObject_CallOneArg(function.ptr(), argument.ptr()); });
  if (!made) throw py::error_already_set();
  return py::reinterpret_steal<py::object>(made);
}

}  // namespace

template <class Take>
py::object ValueReader::taken(Take take) const {
  std::string refused;
  try {
    return take();
  } catch (py::error_already_set& error) {
    refused = py::str(error.value()).cast<std::string>();
    error.restore();
  } catch (const py::builtin_exception& error) {
    refused = error.what();
  }
  fail(refused, "");
}

bool is_picture(py::handle value) {
  if (!PyObject_CheckBuffer(value.ptr())) {
    if (PyType_Check(value.ptr()) || !py::hasattr(value, "__array__")) return false;
    const py::object axes = py::getattr(value, "ndim", py::none());
    return !PyLong_Check(axes.ptr()) || PyLong_AsLong(axes.ptr()) >= 2;
  }
  const auto view = py::reinterpret_steal<py::object>(PyMemoryView_FromObject(value.ptr()));
  if (!view) PyErr_Clear();
  return view && PyMemoryView_GET_BUFFER(view.ptr())->ndim >= 2;
}

py::object ValueReader::texture_of(py::handle picture, bool of_normals) const {
  const py::object& make = of_normals ? parts().normals_from : parts().texture_from;
  py::object texture = taken([&] { return call_python(make, picture); });
  // It was made where that was which it stands in.
  texture.attr("_place") = py::getattr(values_.back(), "_place", py::none());
  return texture;
}

std::string ValueReader::path_text() const {
  std::string path;
  for (const Step& step : path_) {
    if (step.name) path += (path.empty() ? "" : ".") + *step.name;
    if (step.index >= 0) path += fmt::format("[{}]", step.index);
  }
  return path;
}

void ValueReader::fail(const std::string& found, const std::string& expected,
                       const char* kind) const {
  // Ctrl-C, and memory that ran out, are not about what was found.
  const bool is_about_it = !PyErr_Occurred() || (PyErr_ExceptionMatches(PyExc_Exception) &&
                                                 !PyErr_ExceptionMatches(PyExc_MemoryError));
  if (!is_about_it) throw py::error_already_set();
  PyErr_Clear();
  const py::object error = run_or_sleep([&] {
    return parts().errors.attr("scene_error")(
        found, expected, path_text(),
        values_.empty() ? py::none() : py::reinterpret_borrow<py::object>(values_.back()),
        error_class(kind));
  });
  PyErr_SetObject(py::type::of(error).ptr(), error.ptr());
  throw py::error_already_set();
}

void ValueReader::read(py::handle value, Message& message) {
  const ValueClass* made = find_value_class(value);
  if (!made || made->message != message.GetDescriptor()) {
    fail(describe_found(value), with_article(message.GetDescriptor()->name()));
  }
  if (values_.size() >= size_t{kMaxSceneDepth}) {
    const auto [found, expected] = nested_too_deep();
    fail(found, expected, "NestingError");
  }
  pause_();
  if (values_.empty() || made->message == v1::Object::descriptor()) check_node_count(value);
  values_.push_back(value);
  read_fields(value, *made, message);
  values_.pop_back();
}

void ValueReader::read_fields(py::handle value, const ValueClass& made, Message& message) {
  Message* kind =
      made.kind ? message.GetReflection()->MutableMessage(&message, made.kind) : nullptr;
  for (const ValueField& field : made.fields) {
    if (!field.field) continue;
    const py::object held = get_slot(field, value);
    if (held.is_none()) continue;
    const Within within(*this, &field.name, -1);
    Message& target = field.of_kind ? *kind : message;
    const pb::OneofDescriptor* choice = field.field->real_containing_oneof();
    if (choice && target.GetReflection()->HasOneof(target, choice)) {
      fail("set besides " + target.GetReflection()->GetOneofFieldDescriptor(target, choice)->name(),
           "one of them");
    }
    read_field(held, *field.field, target);
  }
  if (message.GetDescriptor() == v1::Node::descriptor()) {
    const py::object shape = get_slot(made.field("shape"), value);
    const Within within(*this, &made.field("shape").name, -1);
    if (!shape.is_none()) add_shape_transform(shape, static_cast<v1::Node&>(message));
  }
}

void ValueReader::read_field(py::handle held, const Field& field, Message& message) {
  if (field.is_map()) {
    read_map(held, message);
  } else if (field.is_repeated()) {
    read_list(held, field, message);
  } else {
    read_one(held, field, message);
  }
}

void ValueReader::read_list(py::handle held, const Field& field, Message& message) {
  PyObject* fast = py::isinstance<py::str>(held) ? nullptr : PySequence_Fast(held.ptr(), "");
  if (!fast) fail(describe_found(held), "a sequence");
  const auto items = py::reinterpret_steal<py::object>(fast);
  const bool is_named = field.message_type() && &field == list_of(field.message_type());
  // The list may change its length while a property of the user's is read.
  for (py::ssize_t i = 0; i < PySequence_Fast_GET_SIZE(fast); ++i) {
    const auto item = py::reinterpret_borrow<py::object>(PySequence_Fast_GET_ITEM(fast, i));
    const Within within(*this, nullptr, i);
    if (is_named) {
      read_member(item, field);
    } else if (field.message_type() == v1::Node::descriptor() &&
               py::isinstance(item, parts().instances)) {
      read_instances(item, field, message);
    } else {
      read_one(item, field, message);
    }
  }
}

/// Of the one map that there is, which the generator of the classes sees to.
void ValueReader::read_map(py::handle held, Message& message) {
  if (!py::isinstance<py::dict>(held)) fail(describe_found(held), "a dict of text");
  auto& map = *static_cast<v1::Metadata&>(message).mutable_properties();
  for (const auto& [key, value] : py::reinterpret_borrow<py::dict>(held)) {
    map[to_text(key)] = to_text(value);
  }
}

void ValueReader::read_one(py::handle held, const Field& field, Message& message) {
  const pb::Reflection& of = *message.GetReflection();
  const auto put = [&](auto set, auto add, auto value) {
    if (field.is_repeated()) {
      (of.*add)(&message, &field, value);
    } else {
      (of.*set)(&message, &field, value);
    }
  };
  using R = pb::Reflection;
  switch (field.cpp_type()) {
    case Field::CPPTYPE_DOUBLE:
      return put(&R::SetDouble, &R::AddDouble, to_number(held));
    case Field::CPPTYPE_FLOAT: {
      const auto number = static_cast<float>(to_number(held));
      if (!std::isfinite(number))
        fail(describe_found(held), "a number that single precision holds");
      return put(&R::SetFloat, &R::AddFloat, number);
    }
    case Field::CPPTYPE_BOOL:
      return put(&R::SetBool, &R::AddBool, to_integer(held, 0, 1) != 0);
    case Field::CPPTYPE_INT32:
      return put(&R::SetInt32, &R::AddInt32,
                 static_cast<int32_t>(to_integer(held, std::numeric_limits<int32_t>::min(),
                                                 std::numeric_limits<int32_t>::max())));
    case Field::CPPTYPE_UINT32:
      return put(&R::SetUInt32, &R::AddUInt32,
                 static_cast<uint32_t>(to_integer(held, 0, std::numeric_limits<uint32_t>::max())));
    case Field::CPPTYPE_ENUM: {
      const std::string text = to_text(held);
      const std::vector<std::string> known = words_of(field);
      const auto found = std::ranges::find(known, spelt(text, known));
      if (found == known.end()) {
        fail(describe_found(held),
             fmt::format("one of {}{}", fmt::join(known, ", "), suggestion(text, known)));
      }
      const auto* value = field.enum_type()->value(static_cast<int>(found - known.begin()));
      return put(&R::SetEnumValue, &R::AddEnumValue, value->number());
    }
    case Field::CPPTYPE_STRING:
      return put(&R::SetString, &R::AddString,
                 named_type(field) ? name_of(held, field) : to_text(held));
    default:
      read_message(held, field,
                   field.is_repeated() ? *of.AddMessage(&message, &field)
                                       : *of.MutableMessage(&message, &field));
  }
}

void ValueReader::read_message(py::handle held, const Field& field, Message& message) {
  const pb::Descriptor* type = field.message_type();
  if (type == v1::Vec3::descriptor() || type == v1::Vec2::descriptor()) {
    read_numbers(held, message);
  } else if (type == v1::Color::descriptor()) {
    read_color(held, static_cast<v1::Color&>(message));
  } else if (type == v1::ColorInput::descriptor() || type == v1::FloatInput::descriptor()) {
    read_input(held, message);
  } else if (type == v1::BlobRef::descriptor()) {
    read_array(held, field, static_cast<v1::BlobRef&>(message));
  } else if (type == v1::Node::descriptor()) {
    read_node(held, static_cast<v1::Node&>(message));
  } else {
    read(held, message);
  }
}

/// A colour, a number, a texture; or the value that says all of it.
void ValueReader::read_input(py::handle held, Message& message) {
  const ValueClass* made = find_value_class(held);
  if (made && made->message == message.GetDescriptor()) return read(held, message);
  const bool is_color = message.GetDescriptor() == v1::ColorInput::descriptor();
  py::object texture = py::reinterpret_borrow<py::object>(held);
  if (!made && is_picture(held)) {
    texture = texture_of(held, false);
    made = find_value_class(texture);
  }
  const pb::Descriptor* type = message.GetDescriptor();
  if (made && made->message == v1::Texture::descriptor()) {
    message.GetReflection()->SetString(&message, type->FindFieldByName("texture"),
                                       collect(texture, *made));
  } else if (made) {
    fail(describe_found(held), is_color ? "a colour or a Texture" : "a number or a Texture");
  } else {
    read_one(held, *type->FindFieldByName("value"), message);
  }
}

/// A name, a grey number or three numbers.
void ValueReader::read_color(py::handle held, v1::Color& color) {
  if (py::isinstance<py::str>(held)) {
    read_numbers(taken([&] { return call_python(parts().color, held); }), color);
  } else if (PyNumber_Check(held.ptr()) && !PySequence_Check(held.ptr())) {
    const double grey = to_number(held);
    color.set_r(grey), color.set_g(grey), color.set_b(grey);
  } else {
    read_numbers(held, color);
  }
}

void ValueReader::read_numbers(py::handle held, Message& message) {
  refuse_masked(held);
  const pb::Descriptor& type = *message.GetDescriptor();
  PyObject* fast = py::isinstance<py::str>(held) ? nullptr : PySequence_Fast(held.ptr(), "");
  if (!fast) fail(describe_found(held), fmt::format("{} numbers", type.field_count()));
  const auto items = py::reinterpret_steal<py::object>(fast);
  if (PySequence_Fast_GET_SIZE(fast) != type.field_count()) {
    fail(fmt::format("{} numbers", PySequence_Fast_GET_SIZE(fast)),
         fmt::format("{}", type.field_count()));
  }
  double numbers[3] = {};
  for (int i = 0; i < type.field_count(); ++i) {
    if (i >= PySequence_Fast_GET_SIZE(fast)) fail("a sequence that changes", "numbers");
    const auto item = py::reinterpret_borrow<py::object>(PySequence_Fast_GET_ITEM(fast, i));
    numbers[i] = to_number(item);
  }
  if (&type == v1::Vec3::descriptor()) {
    auto& vector = static_cast<v1::Vec3&>(message);
    vector.set_x(numbers[0]), vector.set_y(numbers[1]), vector.set_z(numbers[2]);
  } else if (&type == v1::Color::descriptor()) {
    auto& color = static_cast<v1::Color&>(message);
    color.set_r(numbers[0]), color.set_g(numbers[1]), color.set_b(numbers[2]);
  } else {
    auto& vector = static_cast<v1::Vec2&>(message);
    vector.set_x(numbers[0]), vector.set_y(numbers[1]);
  }
}

void ValueReader::read_array(py::handle held, const Field& field, v1::BlobRef& message) {
  const py::object array = taken([&] { return take_blob_array(held, field.name()); });
  const auto [digest, bytes] = blob_of(array.cast<const Array&>());
  blobs_.put(digest, bytes);
  message.set_digest(digest.hex());
  message.set_size(bytes->size());
}

/// A material, texture or object of the scene's own lists.
void ValueReader::read_member(py::handle held, const Field& field) {
  const ValueClass* made = find_value_class(held);
  if (!made && field.message_type() == v1::Texture::descriptor() && is_picture(held))
    return read_member(texture_of(held, false), field);
  if (!made || made->message != field.message_type()) {
    fail(describe_found(held), with_article(field.message_type()->name()));
  }
  collect(held, *made);
}

void ValueReader::refuse_masked(py::handle held) const {
  if (has_masked(held)) fail(kMasked[0], kMasked[1]);
}

double ValueReader::to_number(py::handle held) const {
  if (is_boolean(held)) fail(describe_found(held), "a number");
  if (PyFloat_CheckExact(held.ptr())) {
    const double number = PyFloat_AS_DOUBLE(held.ptr());
    if (!std::isfinite(number)) fail(describe_found(held), "a finite number");
    return number;
  }
  refuse_masked(held);
  const double number = PyFloat_AsDouble(held.ptr());
  if (number == -1 && PyErr_Occurred()) fail(describe_found(held), "a number");
  if (!std::isfinite(number)) fail(describe_found(held), "a finite number");
  return number;
}

int64_t ValueReader::to_integer(py::handle held, int64_t least, int64_t most) const {
  refuse_masked(held);
  const bool wants_boolean = least == 0 && most == 1;
  const std::string expected =
      wants_boolean ? "True or False" : fmt::format("a whole number from {} to {}", least, most);
  if (!wants_boolean && is_boolean(held)) fail(describe_found(held), expected);
  const py::object whole = is_boolean(held)
                               ? py::int_(PyObject_IsTrue(held.ptr()))
                               : py::reinterpret_steal<py::object>(PyNumber_Index(held.ptr()));
  if (!whole) fail(describe_found(held), expected);
  int overflow = 0;
  const long long number = PyLong_AsLongLongAndOverflow(whole.ptr(), &overflow);
  if (overflow || number < least || number > most) fail(describe_found(held), expected);
  return number;
}

std::string ValueReader::to_text(py::handle held) const {
  py::ssize_t size = 0;
  const char* text =
      PyUnicode_Check(held.ptr()) ? PyUnicode_AsUTF8AndSize(held.ptr(), &size) : nullptr;
  if (!text)
    fail(describe_found(held), PyUnicode_Check(held.ptr()) ? "text that is UTF-8" : "text");
  return {text, static_cast<size_t>(size)};
}

}  // namespace tessera
