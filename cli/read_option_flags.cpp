#include "cli/read_option_flags.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <filesystem>

#include "base/error.h"
#include "cli/option_values.h"

namespace tessera {
namespace {

/// Adds an option with one value for each of `names`.
template <typename Value, size_t Count>
void add_choice(CLI::App& command, const char* name, const char* type, const char* text,
                Value& value, const std::array<std::pair<const char*, Value>, Count>& choices) {
  command
      .add_option_function<std::string>(
          name,
          [name, choices, &value](const std::string& given) {
            std::vector<std::string> names;
            for (const auto& choice : choices) names.emplace_back(choice.first);
            const std::string chosen = parse_choice(name, given, names);
            for (const auto& choice : choices)
              if (choice.first == chosen) value = choice.second;
          },
          text)
      ->type_name(type)
      ->group("Reading X3D");
}

}  // namespace

void add_read_options(CLI::App& command, ReadOptions& options) {
  using X3dColor = ReadOptions::Color;
  using Shadows = ReadOptions::Shadows;
  using Texture = ReadOptions::X3dTexture;
  command
      .add_option_function<std::string>(
          "--assets",
          [&options](const std::string& folder) {
            std::error_code failure;
            if (!std::filesystem::is_directory(folder, failure))
              throw usage_error(fmt::format("--assets: there is no folder '{}'{}", folder,
                                            failure ? ": " + failure.message() : ""));
            options.assets = folder;
          },
          "The folder that holds all files which the scene names: pictures, materials, other "
          "scenes [the scene's own]")
      ->type_name("DIR")
      ->group("Scene");
  add_choice(command, "--x3d-color", "display|linear",
             "Colours as they are, or decoded from sRGB and lit in linear light [display]",
             options.x3d_color,
             std::array<std::pair<const char*, X3dColor>, 2>{
                 {{"display", X3dColor::display}, {"linear", X3dColor::linear}}});
  add_choice(command, "--x3d-shadows", "on|file|off",
             "Which lights cast shadows: all, those that the file says, or none [on]",
             options.x3d_shadows,
             std::array<std::pair<const char*, Shadows>, 3>{
                 {{"on", Shadows::on}, {"file", Shadows::file}, {"off", Shadows::off}}});
  add_choice(command, "--x3d-texture", "version|replace|modulate",
             "A coloured texture replaces the material's colour, or multiplies it [version: up to "
             "3.3 it replaces]",
             options.x3d_texture,
             std::array<std::pair<const char*, Texture>, 3>{{{"version", Texture::by_version},
                                                             {"replace", Texture::replace},
                                                             {"modulate", Texture::modulate}}});
  command
      .add_option_function<std::string>(
          "--x3d-weld",
          [&options](const std::string& text) {
            options.x3d_weld = parse_number("--x3d-weld", text);
            if (!(options.x3d_weld > 0))
              throw usage_error(fmt::format("--x3d-weld: {}; expected above 0", text));
          },
          "Points of a node this near share smooth normals as if they were one [only the same do]")
      ->type_name("DISTANCE")
      ->group("Reading X3D");
  command
      .add_flag("--x3d-strict", options.x3d_strict,
                "A picture or an Inline that is missing is an error, not a warning")
      ->group("Reading X3D");
  command
      .add_flag("--x3d-two-sided", options.x3d_two_sided,
                "Show back faces, which files that leave 'solid' out hide")
      ->group("Reading X3D");
}

}  // namespace tessera
