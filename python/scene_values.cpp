#include "python/scene_values.h"

#include <pybind11/stl.h>

#include "front/option_list.h"
#include "front/read_options.h"
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

RenderOptions options_of_python(const std::string& assets) {
  RenderOptions options;
  options.scene = kSceneOfPython;
  if (!assets.empty()) {
    OptionList list;
    add_read_options(list, options.reading);
    assign_option(list, "assets", assets);
  }
  return options;
}

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
  return run_abandonably(
      [made = message_of(scene)](const std::atomic<bool>&) { return scene_digest(made.scene); });
}

void save(py::handle scene, const std::string& path) {
  const auto made = std::make_shared<const SceneWithBlobs>(message_of(scene));
  const EncodedScene encoded = run_abandonably([made, path](const std::atomic<bool>&) {
    return encode_scene_file(path, made->scene, made->blobs);
  });
  // Writing is waited for: after Ctrl-C no file is to appear.
  run_interruptibly(
      [&](const std::atomic<bool>&) { write_scene_file(path, encoded, made->blobs); });
}

std::string to_json(py::handle scene) {
  return run_abandonably([made = message_of(scene)](const std::atomic<bool>&) {
    return encode_scene(made.scene, made.blobs, SceneEncoding::json);
  });
}

py::object from_json(const std::string& text, const py::dict& arrays) {
  SceneWithBlobs made = run_abandonably(
      [text](const std::atomic<bool>&) { return decode_scene(text, SceneEncoding::json, "dict"); });
  for (const auto& [digest, array] : arrays) {
    const auto& [name, blob] = blob_of(array.cast<const Array&>());
    made.blobs.put(name, blob);
  }
  return value_of(made);
}

}  // namespace

void bind_scene(py::module_& module) {
  const auto [found, expected] = nested_too_deep();
  module.attr("nested_too_deep") = py::make_tuple(found, expected);
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
