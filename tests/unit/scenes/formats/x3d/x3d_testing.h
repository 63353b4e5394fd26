#pragma once

#include <string>
#include <vector>

#include "scenes/formats/x3d/x3d_reader.h"
#include "tests/unit/renderer/scene_text.h"
#include "tests/unit/scenes/scene_testing.h"

namespace tessera {

/// `scene` in the classic encoding; a version of "VRML" is VRML97.
inline LoadedScene parse_classic(const std::string& scene, const std::string& version = "3.3",
                                 const ReadOptions& options = {}) {
  const std::string header =
      version == "VRML" ? "#VRML V2.0 utf8\n" : "#X3D V" + version + " utf8\n";
  return parse_x3d(header + scene, "t.x3dv", options);
}

/// What is wrong with a text that is read as "t.wrl".
inline std::string x3d_error(const std::string& text) {
  return error_of([&] { parse_x3d(text, "t.wrl", {}); });
}

/// The values of all its pixels, row by row.
inline std::vector<float> render_loaded(const LoadedScene& loaded, int width, int height) {
  const auto renderer = make_tile_renderer(loaded.scene, loaded.blobs, frame_of(width, height), 1);
  return render_rect(*renderer, {0, 0, width, height}).values;
}

/// Seen from a Viewpoint's default place, unless the scene has one.
inline std::vector<float> render_x3d(const std::string& scene, int width, int height,
                                     const std::string& version = "3.3",
                                     const ReadOptions& options = {}) {
  const bool has_view = scene.find("Viewpoint") != std::string::npos;
  return render_loaded(parse_classic((has_view ? "" : "Viewpoint { } ") + scene, version, options),
                       width, height);
}

}  // namespace tessera
