#include "python/scene_values.h"

#include <pybind11/stl.h>

#include "base/digest.h"
#include "proto/tessera/v1/scene.pb.h"
#include "python/bindings.h"
#include "python/errors.h"
#include "python/gil.h"
#include "python/interruptible.h"
#include "python/value_classes.h"
#include "python/value_reader.h"
#include "python/value_writer.h"

namespace py = pybind11;
namespace pb = google::protobuf;

namespace tessera {

SceneWithBlobs message_of(py::handle scene) {
  SceneWithBlobs made;
  ValueReader(made.scene, made.blobs).read(scene, made.scene);
  return made;
}

std::vector<NamedPart> named_parts(py::handle scene) {
  SceneWithBlobs made;
  ValueReader reader(made.scene, made.blobs);
  reader.read(scene, made.scene);
  return reader.take_named_parts();
}

py::object value_of(const SceneWithBlobs& scene) { return write_value(scene.scene, scene.blobs); }

namespace {

/// Bytes that are equal where two values of one class describe the same: the value's message and
/// what it refers to.
py::bytes describe(py::handle value) {
  const ValueClass* made = find_value_class(value);
  if (!made) throw py::type_error("describe: no value of a scene");
  v1::Scene scene;
  BlobStore blobs;
  if (made->message == v1::Scene::descriptor()) {
    ValueReader(scene, blobs).read(value, scene);
    return serialize_scene(scene);
  }
  const std::unique_ptr<pb::Message> message(
      pb::MessageFactory::generated_factory()->GetPrototype(made->message)->New());
  ValueReader(scene, blobs).read(value, *message);
  return bytes_of(*message) + '\0' + serialize_scene(scene);
}

std::string digest_of(py::handle scene) {
  const SceneWithBlobs made = message_of(scene);
  return run_interruptibly(
      [&](const std::atomic<bool>&) { return Digest::of(serialize_scene(made.scene)).hex(); });
}

void save(py::handle scene, const std::string& path) {
  const SceneWithBlobs made = message_of(scene);
  run_interruptibly(
      [&](const std::atomic<bool>&) { write_scene_file(path, made.scene, made.blobs); });
}

std::string to_json(py::handle scene) {
  const SceneWithBlobs made = message_of(scene);
  return run_interruptibly([&](const std::atomic<bool>&) {
    return encode_scene(made.scene, made.blobs, SceneEncoding::json);
  });
}

py::object from_json(const std::string& text, const py::dict& arrays) {
  SceneWithBlobs made;
  {
    const GilRelease unlocked;
    made = decode_scene(text, SceneEncoding::json, "dict");
  }
  for (const auto& [digest, array] : arrays) {
    const auto& [name, blob] = blob_of(array.cast<const Array&>());
    made.blobs.put(name, blob);
  }
  return value_of(made);
}

}  // namespace

void bind_scene(py::module_& module) {
  module.def("describe", &describe, "Bytes that are equal for equal values.");
  module.def("digest", &digest_of, "The digest that names a scene.");
  module.def("save", &save, "Writes a scene to a file.");
  module.def(
      "named_parts",
      [](py::handle scene) {
        py::list out;
        for (const NamedPart& part : named_parts(scene)) {
          out.append(py::make_tuple(part.kind, part.name, part.path, part.value));
        }
        return out;
      },
      "The materials, textures and objects of a scene: (kind, name, path, value).");
  module.def("to_json", &to_json, "A scene in protobuf's JSON mapping.");
  module.def("from_json", &from_json, "The scene of such a text, and of arrays by their digests.");
  module.def(
      "blob_digest", [](const Array& array) { return blob_of(array).first.hex(); },
      "The digest that names an array.");
  module.def(
      "nearest_name",
      [](const std::string& name, const std::vector<std::string>& names) {
        return nearest_name(name, names);
      },
      "The name that is most like one, or None.");
}

}  // namespace tessera
