#pragma once

#include <string>
#include <vector>

namespace tessera {

struct TemplateFile {
  std::string name;
  std::string text;
};

/// What a new scene begins with.
struct SceneTemplate {
  std::string id;     ///< "empty", "lux" or "crt"
  std::string title;  ///< for the start page
  /// The scene first, then what it includes.
  std::vector<TemplateFile> files;
};

/// An empty scene; LUX's defaults with its sphere of 80 triangles; CRT's new script.
const std::vector<SceneTemplate>& scene_templates();

}  // namespace tessera
