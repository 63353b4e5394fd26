#include "python/value_classes.h"

#include <algorithm>
#include <map>
#include <unordered_map>

#include "base/choice.h"
#include "base/lower_case.h"
#include "proto/tessera/v1/scene.pb.h"
#include "python/generate/enum_names.h"
#include "renderer/accel/make_accelerator.h"

namespace py = pybind11;
namespace pb = google::protobuf;

namespace tessera {
namespace {

class ValueClasses {
 public:
  ValueClasses() {
    const py::module_ messages = py::module_::import("tessera._messages");
    const py::dict made = py::module_::import("tessera._value").attr("CLASSES");
    for (const py::handle name : messages.attr("__all__")) add(messages.attr(name), made);
  }

  const ValueClass* find(PyTypeObject* type) {
    const auto known = by_type_.find(type);
    if (known != by_type_.end()) return known->second;
    // A class of the user's, which is kept so that no other can get its address.
    for (const py::handle base : py::handle(type->tp_mro)) {
      const auto found = by_type_.find(reinterpret_cast<PyTypeObject*>(base.ptr()));
      if (found == by_type_.end() || !found->second) continue;
      Py_INCREF(type);
      return by_type_[type] = found->second;
    }
    return nullptr;
  }

  const ValueClass& of(const pb::Message& message) {
    const pb::Descriptor* type = message.GetDescriptor();
    const pb::FieldDescriptor* kind = nullptr;
    if (unions_.contains(type)) {
      kind = message.GetReflection()->GetOneofFieldDescriptor(message, type->oneof_decl(0));
    }
    return *by_kind_.at({type, kind});
  }

 private:
  void add(const py::object& generated, const py::dict& made) {
    const auto message_name = generated.attr("_MESSAGE").cast<std::string>();
    const auto kind_name = generated.attr("_KIND").cast<std::string>();
    auto* added = new ValueClass;  // for as long as the process
    added->message = v1::Scene::descriptor()->file()->FindMessageTypeByName(
        message_name.substr(std::string("tessera.v1.").size()));
    if (!added->message) added->message = nested(message_name);
    added->kind = kind_name.empty() ? nullptr : added->message->FindFieldByName(kind_name);
    added->made = made[py::make_tuple(message_name, kind_name)];
    if (added->kind) unions_[added->message] = true;
    for (const py::handle item : generated.attr("_FIELDS")) {
      const auto name = item.cast<std::string>();
      const pb::FieldDescriptor* own =
          added->kind ? added->kind->message_type()->FindFieldByName(name) : nullptr;
      added->fields.push_back({name, own ? own : added->message->FindFieldByName(name),
                               own != nullptr, generated.attr(item)});
    }
    by_type_[reinterpret_cast<PyTypeObject*>(generated.ptr())] = added;
    by_kind_[{added->message, added->kind}] = added;
  }

  static const pb::Descriptor* nested(const std::string& full_name) {
    return v1::Scene::descriptor()->file()->pool()->FindMessageTypeByName(full_name);
  }

  std::unordered_map<PyTypeObject*, const ValueClass*> by_type_;
  std::map<std::pair<const pb::Descriptor*, const pb::FieldDescriptor*>, const ValueClass*>
      by_kind_;
  std::map<const pb::Descriptor*, bool> unions_;
};

ValueClasses& value_classes() {
  static auto* const classes = new ValueClasses;
  return *classes;
}

}  // namespace

const ValueField& ValueClass::field(const std::string& name) const {
  if (const ValueField* found = find(name)) return *found;
  throw py::key_error(name);
}

const ValueField* ValueClass::find(std::string_view name) const {
  const auto found = std::ranges::find(fields, name, &ValueField::name);
  return found == fields.end() ? nullptr : &*found;
}

std::vector<std::string> words_of(const pb::FieldDescriptor& field) {
  if (field.enum_type()) return python_names(*field.enum_type());
  return field.full_name() == "tessera.v1.Settings.accelerator" ? available_accelerators()
                                                                : std::vector<std::string>();
}

std::string spelt(const std::string& text, const std::vector<std::string>& words) {
  return find_choice(words, lower_case(text)).value_or(text);
}

const ValueClass* find_value_class(py::handle value) {
  return value_classes().find(Py_TYPE(value.ptr()));
}

const ValueClass& value_class_of(const pb::Message& message) { return value_classes().of(message); }

py::object get_slot(const ValueField& field, py::handle value) {
  PyObject* const slot = field.descriptor.ptr();
  PyObject* held = Py_TYPE(slot)->tp_descr_get(slot, value.ptr(),
                                               reinterpret_cast<PyObject*>(Py_TYPE(value.ptr())));
  if (held) return py::reinterpret_steal<py::object>(held);
  PyErr_Clear();
  return py::none();
}

void set_slot(const ValueField& field, py::handle value, py::handle held) {
  PyObject* const slot = field.descriptor.ptr();
  if (Py_TYPE(slot)->tp_descr_set(slot, value.ptr(), held.ptr())) throw py::error_already_set();
}

}  // namespace tessera
