#include <fmt/format.h>

#include <algorithm>
#include <unordered_map>

#include "proto/wire/scene_codec.h"
#include "python/array_source.h"
#include "python/gil.h"
#include "python/value_reader.h"
#include "renderer/scene/scene_graph.h"

// The part of ValueReader that makes nodes: of shapes, lights, objects and many instances.

namespace py = pybind11;

namespace tessera {
namespace {

/// Counts the nodes of the message that a value stands for. Each value is visited once, however
/// often it stands in others: nodes that are listed twice at each level double their number.
class NodeCounter {
 public:
  /// The nodes inside of `value`, or kMaxNodeVisits + 1 where they are more. `depth` is the number
  /// of values around it.
  size_t count_in(py::handle value, int depth) {
    const ValueClass* made = find_value_class(value);
    if (!made || depth > kMaxSceneDepth) return 0;  // which reading will refuse
    const auto known = counts_.find(value.ptr());
    if (known != counts_.end()) return known->second;
    size_t count = 0;
    for (const ValueField& field : made->fields) {
      const auto* type = field.field ? field.field->message_type() : nullptr;
      if (type != v1::Node::descriptor() && type != v1::Shape::descriptor()) continue;
      const py::object held = get_slot(field, value);
      count += field.field->is_repeated() ? count_list(held, depth) : count_in(held, depth + 1);
    }
    count = std::min(count, kMaxNodeVisits + 1);
    if (count > 0) counts_[value.ptr()] = count;
    return count;
  }

 private:
  /// Other iterables than these are not looked into: some can be read only once.
  size_t count_list(py::handle held, int depth) {
    if (!PyList_Check(held.ptr()) && !PyTuple_Check(held.ptr())) return 0;
    size_t count = 0;
    for (py::ssize_t i = 0;; ++i) {
      pause_();  // in which the list may shrink
      if (i >= PySequence_Fast_GET_SIZE(held.ptr())) break;
      const auto item = py::reinterpret_borrow<py::object>(PySequence_Fast_GET_ITEM(held.ptr(), i));
      count += 1 + count_in(item, depth + 1);
    }
    return count;
  }

  GilPauses pause_;
  std::unordered_map<PyObject*, size_t> counts_;
};

}  // namespace

void ValueReader::check_node_count(py::handle value) {
  NodeCounter counter;
  node_count_ += counter.count_in(value, 0);
  constexpr size_t kMany = 1000;
  if (node_count_ > kMany) free_unlocked(std::move(counter));
  if (node_count_ > kMaxNodeVisits) {
    fail(fmt::format("more than {} nodes", kMaxNodeVisits), "fewer");
  }
}

void ValueReader::read_node(py::handle held, v1::Node& node) {
  const ValueClass* made = find_value_class(held);
  if (made && made->message == v1::Shape::descriptor()) {
    read(held, *node.mutable_shape());
    add_shape_transform(held, node);
  } else if (made && made->message == v1::Light::descriptor()) {
    read(held, *node.mutable_light());
  } else if (made && made->message == v1::Object::descriptor()) {
    node.set_instance_of(collect(held, *made));
  } else {
    read(held, node);
  }
}

/// A shape's own transform acts first, then that of its node. A billboard turns between them.
void ValueReader::add_shape_transform(py::handle shape, v1::Node& node) {
  const ValueClass& made = *find_value_class(shape);
  const ValueField& field = made.field("transform");
  const py::object held = get_slot(field, shape);
  if (held.is_none()) return;
  const Within within(*this, &field.name, -1);
  v1::Transform transform;
  read(held, transform);
  if (transform.steps().empty()) return;
  if (node.has_billboard_axis()) {
    v1::Node& child = *node.add_children();
    child.mutable_shape()->Swap(node.mutable_shape());
    node.clear_shape();
    *child.mutable_transform() = transform;
    return;
  }
  for (v1::TransformKey& key : *node.mutable_keys()) {
    key.mutable_transform()->MergeFrom(transform);
  }
  if (node.keys().empty()) node.mutable_transform()->MergeFrom(transform);
}

void ValueReader::read_instances(py::handle instances, const Field& field, Message& message) {
  values_.push_back(instances);
  const py::object object = instances.attr("object"), names = instances.attr("names");
  const ValueClass* made = find_value_class(object);
  const std::string name = made ? collect(object, *made) : to_text(object);
  const py::object transforms = instances.attr("_transforms");
  if (!py::isinstance<Array>(transforms)) fail(describe_found(transforms), "an Array");
  const Array& matrices = transforms.cast<const Array&>();
  const Array::Shape& shape = matrices.shape();
  if (matrices.type().code != 'd' || shape.size() != 3 || shape[1] != 3 || shape[2] != 4) {
    fail(fmt::format("transforms of shape {}", shape_text(shape)), "(any, 3, 4) of float64");
  }
  py::list texts;
  if (!names.is_none()) {
    texts = py::list(names);
    if (std::ssize(texts) != shape[0]) {
      fail(fmt::format("{} names", texts.size()), fmt::format("{}, one an instance", shape[0]));
    }
  }
  const auto* numbers = static_cast<const double*>(matrices.data());
  for (py::ssize_t i = 0; i < shape[0]; ++i, numbers += 12) {
    auto& node = static_cast<v1::Node&>(*message.GetReflection()->AddMessage(&message, &field));
    node.set_instance_of(name);
    if (!names.is_none()) node.set_name(to_text(texts[static_cast<size_t>(i)]));
    auto& rows = *node.mutable_transform()->add_steps()->mutable_matrix()->mutable_rows();
    rows.Reserve(12);
    rows.Add(numbers, numbers + 12);
  }
  values_.pop_back();
}

}  // namespace tessera
