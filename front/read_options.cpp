#include "front/read_options.h"

#include <fmt/format.h>

#include <array>
#include <filesystem>

#include "base/error.h"
#include "base/file.h"
#include "front/option_values.h"

namespace tessera {
namespace {

/// Adds an option with one value for each of `names`.
template <typename Value, size_t Count>
void add_choice(OptionGroup& group, const char* name, const char* type, const char* text,
                Value& value, const std::array<std::pair<const char*, Value>, Count>& choices) {
  group.add(name, type, text, [name, choices, &value](const std::string& given) {
    std::vector<std::string> names;
    for (const auto& choice : choices) names.emplace_back(choice.first);
    const std::string chosen = parse_choice(name, given, names);
    for (const auto& choice : choices)
      if (choice.first == chosen) value = choice.second;
  });
}

}  // namespace

void add_read_options(OptionList& list, ReadOptions& options) {
  using X3dColor = ReadOptions::Color;
  using Shadows = ReadOptions::Shadows;
  using X3dTexture = ReadOptions::X3dTexture;
  using Up = ReadOptions::Up;
  OptionGroup scene(list, "Scene");
  scene.add_text(
      "--format", "NAME",
      "The format of the scene's own file, such as obj, whatever its name says; standard "
      "input needs it where the content does not tell [by the ending, or the content]",
      options.format);
  scene.add("--assets", "DIR",
            "The folder that holds all files which the scene names: pictures, materials, other "
            "scenes [the scene's own]",
            [&options](const std::string& folder) {
              std::error_code failure;
              if (!std::filesystem::is_directory(folder, failure))
                throw usage_error(fmt::format("--assets: there is no folder '{}'{}", folder,
                                              failure ? ": " + failure.message() : ""));
              options.assets = folder;
            });
  scene.add(
      "--environment", "FILE",
      "A panorama in place of the background, such as an .exr or .hdr; it alone lights a model "
      "that brings no lights",
      [&options](const std::string& file) {
        try {
          check_input_file(file, UINT64_MAX);
        } catch (const Error& error) {
          throw usage_error(fmt::format("--environment: {}", error.what()));
        }
        options.environment = file;
      });
  add_choice(
      scene, "--up", "y|z",
      "Which axis points up in a model that comes without a view, for its camera, lights and "
      "background; coordinates stay as they are [y; z for STL]",
      options.up, std::array<std::pair<const char*, Up>, 2>{{{"y", Up::y}, {"z", Up::z}}});
  scene.add_flag(
      "--strict",
      "What is wrong in a file and would be mended or done without, with a warning, is an "
      "error; that includes --x3d-strict",
      options.strict);
  scene.add_flag("--two-sided",
                 "Show back faces, which glTF's one-sided materials and X3D's 'solid' hide",
                 options.two_sided);
  OptionGroup group(list, "Reading X3D");
  add_choice(group, "--x3d-color", "display|linear",
             "Colours as they are, or decoded from sRGB and lit in linear light [display]",
             options.x3d_color,
             std::array<std::pair<const char*, X3dColor>, 2>{
                 {{"display", X3dColor::display}, {"linear", X3dColor::linear}}});
  add_choice(group, "--x3d-shadows", "on|file|off",
             "Which lights cast shadows: all, those that the file says, or none [on]",
             options.x3d_shadows,
             std::array<std::pair<const char*, Shadows>, 3>{
                 {{"on", Shadows::on}, {"file", Shadows::file}, {"off", Shadows::off}}});
  add_choice(
      group, "--x3d-texture", "version|replace|modulate",
      "A coloured texture replaces the material's colour, or multiplies it [version: up to "
      "3.3 it replaces]",
      options.x3d_texture,
      std::array<std::pair<const char*, X3dTexture>, 3>{{{"version", X3dTexture::by_version},
                                                         {"replace", X3dTexture::replace},
                                                         {"modulate", X3dTexture::modulate}}});
  group.add(
      "--x3d-weld", "DISTANCE",
      "Points of a node this near share smooth normals as if they were one [only the same do]",
      [&options](const std::string& text) {
        options.x3d_weld = parse_number("--x3d-weld", text);
        if (!(options.x3d_weld > 0))
          throw usage_error(fmt::format("--x3d-weld: {}; expected above 0", text));
      });
  group.add_flag("--x3d-strict",
                 "A picture or an Inline that is missing is an error, not a warning",
                 options.x3d_strict);
  group.add_flag("--x3d-two-sided", "The same as --two-sided", options.two_sided);
}

}  // namespace tessera
