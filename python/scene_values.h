#pragma once

#include <pybind11/pybind11.h>

#include <string>

#include "front/render_options.h"
#include "proto/wire/scene_codec.h"

namespace tessera {

inline constexpr char kSceneOfPython[] = "scene";  ///< what errors call one that is no file

/// The options of a scene made in Python whose included files are in the folder `assets`; empty: in
/// the current one. Throws usage_error where there is no such folder.
RenderOptions options_of_python(const std::string& assets);

/// The description that a `tessera.Scene` stands for, its arrays as blobs. Throws Python's
/// SceneError where a value does not fit. Needs the GIL.
SceneWithBlobs message_of(pybind11::handle scene);

/// The `tessera.Scene` of a description. Needs the GIL.
pybind11::object value_of(const SceneWithBlobs& scene);

}  // namespace tessera
