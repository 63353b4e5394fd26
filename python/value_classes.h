#pragma once

#include <google/protobuf/message.h>
#include <pybind11/pybind11.h>

#include <string>
#include <string_view>
#include <vector>

namespace tessera {

/// One attribute of a Python class and the field that it becomes.
struct ValueField {
  std::string name;
  const google::protobuf::FieldDescriptor* field;  ///< null: Python's alone, as Shape.transform
  bool of_kind;                 ///< belongs to the message of the kind, not to that of the union
  pybind11::object descriptor;  ///< of the slot itself, whatever property hides it
};

/// A class of `tessera._messages` and the message that its values become.
struct ValueClass {
  pybind11::object made;                          ///< the class that users see, maybe derived
  const google::protobuf::Descriptor* message;    ///< of a Sphere: Shape
  const google::protobuf::FieldDescriptor* kind;  ///< of a Sphere: Shape.sphere; else null
  std::vector<ValueField> fields;

  const ValueField& field(const std::string& name) const;
  /// Null where there is none of that name.
  const ValueField* find(std::string_view name) const;
};

/// The words that a field takes, as they are spelt; empty: any text, or none.
std::vector<std::string> words_of(const google::protobuf::FieldDescriptor& field);
/// The one of `words` that `text` is in any case and with either dash; else `text` itself.
std::string spelt(const std::string& text, const std::vector<std::string>& words);

/// The class of a value, or of what its class derives from; null for anything else. Needs the GIL.
const ValueClass* find_value_class(pybind11::handle value);
/// The class whose values a message becomes. Needs the GIL.
const ValueClass& value_class_of(const google::protobuf::Message& message);

/// What the slot holds; None where it was never set.
pybind11::object get_slot(const ValueField& field, pybind11::handle value);
void set_slot(const ValueField& field, pybind11::handle value, pybind11::handle held);

}  // namespace tessera
