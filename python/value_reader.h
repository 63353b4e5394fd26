#pragma once

#include <google/protobuf/message.h>
#include <pybind11/pybind11.h>

#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "proto/tessera/v1/scene.pb.h"
#include "proto/wire/blob_store.h"
#include "python/gil.h"
#include "python/value_classes.h"

namespace tessera {

/// The scene's list of materials, of textures or of objects; null for any other type.
const google::protobuf::FieldDescriptor* list_of(const google::protobuf::Descriptor* type);
/// The type that a string field may be given instead of its name; null: none.
/// Needs the GIL.
const google::protobuf::Descriptor* named_type(const google::protobuf::FieldDescriptor& field);
/// What a value is, for messages: a number or text itself, or "a Sphere".
std::string describe_found(pybind11::handle value);
/// What is said of values inside themselves: what was found and what was expected.
std::pair<std::string, std::string> nested_too_deep();
/// Whether it is an array of at least two axes, which stands for a texture of its own.
bool is_picture(pybind11::handle value);
/// Equal messages, equal bytes.
std::string bytes_of(const google::protobuf::Message& message);

/// A material, texture or object of a scene.
struct NamedPart {
  std::string kind;  ///< "material" ...
  std::string name;  ///< its own, or what it got by its digest
  std::string path;  ///< where it was first met: "nodes[3].materials[0]"
  pybind11::object value;
};

/// Makes the description of a scene from Python values. Whatever does not fit is told as a
/// SceneError with the way to it ("nodes[3].shape.radius") and where the value was made. Needs the
/// GIL.
///
/// Materials, textures and objects may stand where their names are wanted. Each is put into the
/// scene's list when first met; equal ones once; one without a name is named by its digest, so that
/// the same script makes the same scene.
class ValueReader {
 public:
  ValueReader(v1::Scene& scene, BlobStore& blobs) : scene_(scene), blobs_(blobs) {}

  /// Fills `message` from a value of its class.
  void read(pybind11::handle value, google::protobuf::Message& message);
  /// What stands in a list of nodes: a node, or a shape with its own transform, a light or an
  /// object.
  void read_node(pybind11::handle held, v1::Node& node);
  /// Those that were read, each once.
  std::vector<NamedPart> take_named_parts() { return std::move(named_parts_); }

 private:
  using Field = google::protobuf::FieldDescriptor;
  using Message = google::protobuf::Message;
  struct Step {
    const std::string* name;
    pybind11::ssize_t index;  ///< -1: none
  };
  /// Materials, textures or objects that were met.
  struct Collection {
    std::unordered_map<PyObject*, std::string> name_of;    ///< empty while it is being read
    std::unordered_map<std::string, std::string> by_name;  ///< the message in bytes
  };
  class Within;

  std::string path_text() const;
  /// What `take` returns; an exception that it raises is told with the place and the way there.
  template <class Take>
  pybind11::object taken(Take take) const;
  /// `kind`: the class of the error, a SceneError.
  [[noreturn]] void fail(const std::string& found, const std::string& expected,
                         const char* kind = "SceneError") const;
  void read_fields(pybind11::handle value, const ValueClass& made, Message& message);
  void read_field(pybind11::handle held, const Field& field, Message& message);
  void read_list(pybind11::handle held, const Field& field, Message& message);
  void read_map(pybind11::handle held, Message& message);
  void read_one(pybind11::handle held, const Field& field, Message& message);
  void read_message(pybind11::handle held, const Field& field, Message& message);
  void read_input(pybind11::handle held, Message& message);
  void read_color(pybind11::handle held, v1::Color& color);
  void read_numbers(pybind11::handle held, Message& message);
  void read_array(pybind11::handle held, const Field& field, v1::BlobRef& message);
  /// Refuses a scene, an object or a node with too many nodes in it, before they are read.
  void check_node_count(pybind11::handle value);
  void add_shape_transform(pybind11::handle shape, v1::Node& node);
  void read_instances(pybind11::handle instances, const Field& field, Message& message);
  /// The texture that an array stands for. `of_normals`: of numbers, not of colours.
  pybind11::object texture_of(pybind11::handle picture, bool of_normals) const;
  void read_member(pybind11::handle held, const Field& field);
  void refuse_masked(pybind11::handle held) const;
  double to_number(pybind11::handle held) const;
  int64_t to_integer(pybind11::handle held, int64_t least, int64_t most) const;
  std::string to_text(pybind11::handle held) const;
  /// The name of a material, texture or object that stands where `field` wants one.
  std::string name_of(pybind11::handle held, const Field& field);
  std::string collect(pybind11::handle thing, const ValueClass& made);

  v1::Scene& scene_;
  BlobStore& blobs_;
  std::vector<Step> path_;
  std::vector<pybind11::handle> values_;  ///< those being read, the outermost first
  std::unordered_map<const google::protobuf::Descriptor*, Collection> collections_;
  std::vector<NamedPart> named_parts_;
  size_t node_count_ = 0;  ///< in the values that check_node_count() was called for
  GilPauses pause_;
  std::vector<pybind11::object> collected_;  ///< keeps alive what name_of has addresses of
};

/// One step of the way to what is being read, for as long as it lives.
class ValueReader::Within {
 public:
  Within(ValueReader& reader, const std::string* name, py::ssize_t index) : reader_(reader) {
    reader_.path_.push_back({name, index});
  }
  ~Within() { reader_.path_.pop_back(); }
  Within(const Within&) = delete;
  Within& operator=(const Within&) = delete;

 private:
  ValueReader& reader_;
};

}  // namespace tessera
