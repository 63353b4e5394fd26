#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scenes/import/loaded_scene.h"

namespace tessera {

/// A scene on which error is measured against time.
struct AccuracyScene {
  /// Edges of a part of the picture, as shares of its width and height from the top left.
  struct Part {
    double x0, y0, x1, y1;
  };
  std::string name;
  std::string about;             ///< one line: what is hard about it
  LoadedScene loaded;            ///< its settings have the size that it is usually measured at
  std::vector<Part> left_out{};  ///< pixels that do not count
};

/// edge, checker, textured, lens, mirrors, cornell, furnace, sphere-light, rectangle-light,
/// sky-wall, plates, glossy, caustic, many-lights.
const std::vector<std::string>& accuracy_scene_names();
/// The same scene, bit for bit, on every machine. Throws a usage Error for an unknown name.
AccuracyScene make_accuracy_scene(std::string_view name);

}  // namespace tessera
