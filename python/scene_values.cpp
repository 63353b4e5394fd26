#include "python/scene_values.h"

#include "proto/tessera/v1/scene.pb.h"
#include "python/bindings.h"
#include "python/errors.h"

namespace py = pybind11;

namespace tessera {

SceneWithBlobs message_of(py::handle scene) {
  return decode_scene(py::cast<std::string>(scene), SceneEncoding::text, "scene");
}

py::object value_of(const SceneWithBlobs& scene) {
  return py::str(encode_scene(scene.scene, scene.blobs, SceneEncoding::text));
}

void bind_scene(py::module_&) {}

}  // namespace tessera
