#pragma once

#include <gtest/gtest.h>

#include <string>

#include "base/error.h"
#include "scenes/formats/crt/crt_reader.h"

namespace tessera::crt_test {

inline const std::string kCamera =
    "cam = Camera { position -> vec3(0, 0, -5) pointing -> vec3(0, 0, 0) fov -> 60 }\n";
inline const std::string kMaterial = "m = Material { color -> rgb(1, 1, 1) }\n";

inline LoadedScene read(const std::string& text, int32_t frame = 0) {
  return parse_crt(text, "x.crt", {}, frame);
}

/// A whole script around what stands before Settings and what stands in Scene.
inline std::string script(const std::string& before, const std::string& scene = "",
                          const std::string& settings = "") {
  return kCamera + kMaterial + before + "\nSettings { camera -> cam " + settings + " }\nScene {\n" +
         scene + "\n}\n";
}

inline v1::Scene scene_of(const std::string& before, const std::string& scene,
                          const std::string& settings = "", int32_t frame = 0) {
  return read(script(before, scene, settings), frame).scene;
}

inline std::string sphere(const std::string& radius, const std::string& center = "vec3(0, 0, 0)") {
  return "Sphere { center -> " + center + " radius -> " + radius + " material -> m }\n";
}

/// The value of an expression that is a number above 0.
inline double number(const std::string& expression, const std::string& before = "",
                     int32_t frame = 0) {
  const v1::Scene scene = scene_of(before + "\nvalue = " + expression, sphere("value"), "", frame);
  return scene.nodes(0).shape().sphere().radius();
}

inline bool truth(const std::string& expression, const std::string& before = "") {
  return number("(" + expression + ") ? 1 : 2", before) == 1;
}

inline std::string text(const std::string& expression, const std::string& before = "") {
  return read(script(before, "", "title -> " + expression)).scene.metadata().title();
}

/// All that is wrong with a script.
inline std::string complaint(const std::string& whole_script) {
  try {
    read(whole_script);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::bad_scene);
    return error.what();
  }
  return "";
}

inline std::string complaint_of(const std::string& before, const std::string& scene = "",
                                const std::string& settings = "") {
  return complaint(script(before, scene, settings));
}

}  // namespace tessera::crt_test
