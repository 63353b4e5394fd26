#include "python/scene_values.h"

#include <pybind11/stl.h>

#include "front/option_list.h"
#include "front/read_options.h"
#include "proto/tessera/v1/scene.pb.h"
#include "python/array.h"
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

/// The bytes of a message, if there is one, and of a scene.
Array described(std::unique_ptr<pb::Message> message, v1::Scene scene) {
  size_t size = 0;
  {
    const GilRelease unlocked;
    size = (message ? message->ByteSizeLong() : 0) + scene.ByteSizeLong();
  }
  std::vector<uint8_t> bytes =
      run_unlocked(size, [message = std::shared_ptr<const pb::Message>(std::move(message)),
                          scene = std::move(scene)](const std::atomic<bool>&) {
        const std::string text =
            (message ? bytes_of(*message) + '\0' : std::string()) + serialize_scene(scene);
        return std::vector<uint8_t>(text.begin(), text.end());
      });
  const auto count = static_cast<py::ssize_t>(bytes.size());
  return {std::move(bytes), {count}};
}

/// Bytes that are equal where two values of one class describe the same: the value's message and
/// what it refers to.
Array describe(py::handle value) {
  const ValueClass* made = find_value_class(value);
  if (!made) throw py::type_error("describe: no value of a scene");
  v1::Scene scene;
  BlobStore blobs;
  if (made->message == v1::Scene::descriptor()) {
    ValueReader(scene, blobs).read(value, scene);
    return described(nullptr, std::move(scene));
  }
  // The transform of a shape is a field of its node's message, not of its own.
  const bool is_shape = made->message == v1::Shape::descriptor();
  const pb::Descriptor* type = is_shape ? v1::Node::descriptor() : made->message;
  std::unique_ptr<pb::Message> message(
      pb::MessageFactory::generated_factory()->GetPrototype(type)->New());
  ValueReader reader(scene, blobs);
  is_shape ? reader.read_node(value, static_cast<v1::Node&>(*message))
           : reader.read(value, *message);
  return described(std::move(message), std::move(scene));
}

std::string digest_of(py::handle scene) {
  return run_abandonably(
      [made = message_of(scene)](const std::atomic<bool>&) { return scene_digest(made.scene); });
}

void save(py::handle scene, const std::string& path) {
  auto made = std::make_shared<const SceneWithBlobs>(message_of(scene));
  EncodedScene encoded = run_abandonably([made, path](const std::atomic<bool>&) {
    return encode_scene_file(path, made->scene, made->blobs);
  });
  // Writing is waited for: after Ctrl-C no file is to appear.
  run_interruptibly(
      [&path, encoded = std::move(encoded), made = std::move(made)](const std::atomic<bool>&) {
        write_scene_file(path, encoded, made->blobs);
      });
}

std::string to_json(py::handle scene) {
  return run_abandonably([made = message_of(scene)](const std::atomic<bool>&) {
    return encode_scene(made.scene, made.blobs, SceneEncoding::json);
  });
}

py::object from_json(std::string text, const py::dict& arrays) {
  SceneWithBlobs made = run_abandonably([text = std::move(text)](const std::atomic<bool>&) {
    return decode_scene(text, SceneEncoding::json, "");
  });
  for (const auto& [digest, array] : arrays) {
    const auto& [name, blob] = blob_of(array.cast<const Array&>());
    made.blobs.put(name, blob);
  }
  const py::object scene = value_of(made);
  free_unlocked(std::move(made));
  return scene;
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
