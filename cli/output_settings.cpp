#include "cli/output_settings.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "base/error.h"
#include "cli/option_values.h"
#include "job/picture_settings.h"

namespace tessera {
namespace {

size_t index_of(const std::vector<std::string>& names, const std::string& name) {
  return static_cast<size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

}  // namespace

const std::vector<std::string>& tone_map_names() {
  static const std::vector<std::string> names{"clamp", "reinhard", "reinhard-luminance", "filmic",
                                              "linear"};
  return names;
}

const std::vector<std::string>& transfer_names() {
  static const std::vector<std::string> names{"srgb", "display", "gamma"};
  return names;
}

OutputSettings output_settings(const std::string& scene_file, const v1::Output& of_scene,
                               const OutputOptions& options) {
  return picture_settings(scene_file, with_options(of_scene, options));
}

v1::Output with_options(v1::Output output, const OutputOptions& options) {
  if (options.tone_map) {
    output.set_tone_map(
        static_cast<v1::Output::ToneMap>(index_of(tone_map_names(), *options.tone_map)));
  }
  if (options.gamma) {
    output.set_gamma(*options.gamma);
    output.set_transfer(v1::Output::GAMMA);
  }
  if (options.transfer) {
    output.set_transfer(
        static_cast<v1::Output::Transfer>(index_of(transfer_names(), *options.transfer)));
  }
  if (options.exposure) output.set_exposure(*options.exposure);
  return output;
}

void add_output_options(CLI::App& command, OutputOptions& options) {
  const auto add = [&](const char* name, const char* type, const std::string& text, auto assign) {
    command.add_option_function<std::string>(name, assign, text)
        ->type_name(type)
        ->group("From light to bytes (PNG, JPEG ...)");
  };
  const auto of_scene = [](const std::vector<std::string>& names) {
    return fmt::format("{} or {} [the scene's, or {}]",
                       fmt::join(names.begin(), names.end() - 1, ", "), names.back(),
                       names.front());
  };
  add("--exposure", "STOPS", "Twice the light for each, before all else [the scene's, or 0]",
      [&options](const std::string& text) { options.exposure = parse_number("--exposure", text); });
  add("--tone-map", "KIND", of_scene(tone_map_names()), [&options](const std::string& text) {
    options.tone_map = parse_choice("--tone-map", text, tone_map_names());
  });
  add("--transfer", "KIND", of_scene(transfer_names()), [&options](const std::string& text) {
    options.transfer = parse_choice("--transfer", text, transfer_names());
  });
  add("--gamma", "G", "--transfer gamma with this exponent [the scene's, or 2.2]",
      [&options](const std::string& text) {
        const double gamma = parse_number("--gamma", text);
        if (!(gamma > 0)) throw usage_error(fmt::format("--gamma: {}; expected above 0", text));
        options.gamma = gamma;
      });
}

}  // namespace tessera
