#include "front/output_settings.h"

#include <fmt/format.h>

#include <algorithm>

#include "front/located.h"
#include "front/option_values.h"
#include "job/picture_settings.h"

namespace tessera {
namespace {

size_t index_of(const std::vector<std::string>& names, const std::string& name) {
  return static_cast<size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

std::optional<ColorManagement> color_management(const OutputOptions& options) {
  const bool is_view = options.ocio_view || options.ocio_display;
  if (!is_view && !options.ocio_space) {
    if (options.ocio_input) {
      throw usage_error("--ocio-input by itself; expected --ocio-view or --ocio-space beside it");
    }
    return std::nullopt;
  }
  if (is_view && options.ocio_space) {
    throw usage_error("--ocio-space beside a view; expected one of them");
  }
  if (options.tone_map || options.transfer || options.gamma) {
    throw usage_error(
        "--tone-map, --transfer or --gamma beside OpenColorIO, which takes their place; expected "
        "one of them");
  }
  ColorManagement names;
  if (options.ocio_input) names.input = *options.ocio_input;
  names.display = options.ocio_display.value_or("");
  if (options.ocio_view && *options.ocio_view != "default") names.view = *options.ocio_view;
  names.color_space = options.ocio_space.value_or("");
  return names;
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
  try {
    OutputSettings result = picture_settings(with_options(of_scene, options));
    result.color_management = color_management(options);
    result.bits = options.bits;
    return result;
  } catch (const Error& error) {
    if (error.code() != ExitCode::bad_scene) throw;
    throw located(scene_file, error.what());
  }
}

v1::Output with_options(v1::Output output, const OutputOptions& options) {
  if (options.gamma && options.transfer && *options.transfer != "gamma") {
    throw usage_error(fmt::format(
        "--gamma: is for --transfer gamma; expected that beside it, not {}", *options.transfer));
  }
  if (options.tone_map) {
    output.set_tone_map(
        static_cast<v1::Output::ToneMap>(index_of(tone_map_names(), *options.tone_map)));
  }
  if (options.transfer) {
    output.set_transfer(
        static_cast<v1::Output::Transfer>(index_of(transfer_names(), *options.transfer)));
  }
  if (options.gamma) {
    output.set_gamma(*options.gamma);
    output.set_transfer(v1::Output::GAMMA);
  }
  if (options.exposure) output.set_exposure(*options.exposure);
  return output;
}

void add_output_options(OptionList& list, OutputOptions& options) {
  OptionGroup group(list, "From light to bytes (PNG, JPEG ...)");
  const auto of_scene = [](const std::vector<std::string>& names) {
    return fmt::format("{} or {} [the scene's, or {}]",
                       fmt::join(names.begin(), names.end() - 1, ", "), names.back(),
                       names.front());
  };
  group.add("--exposure", "STOPS",
            "Twice the light for each, before all else; 'auto' brings surfaces to middle grey, and "
            "tells the number; of an animation that of its first frame [the scene's, or 0]",
            [&options](const std::string& text) {
              options.auto_exposure = text == "auto";
              options.exposure.reset();
              if (!options.auto_exposure) options.exposure = parse_number("--exposure", text);
            });
  group
      .add("--tone-map", "KIND", of_scene(tone_map_names()),
           [&options](const std::string& text) {
             options.tone_map = parse_choice("--tone-map", text, tone_map_names());
           })
      .choices = tone_map_names();
  group
      .add("--transfer", "KIND", of_scene(transfer_names()),
           [&options](const std::string& text) {
             options.transfer = parse_choice("--transfer", text, transfer_names());
           })
      .choices = transfer_names();
  group.add("--gamma", "G", "--transfer gamma with this exponent [the scene's, or 2.2]",
            [&options](const std::string& text) {
              const double gamma = parse_number("--gamma", text);
              if (!(gamma > 0))
                throw usage_error(fmt::format("--gamma: {}; expected above 0", text));
              options.gamma = gamma;
            });
  static const std::vector<std::string> bits{"8", "16"};
  group
      .add("--bits", "N", "8, or 16 for PNG and TIFF: bits of a channel [8]",
           [&options](const std::string& text) {
             options.bits = parse_choice("--bits", text, bits) == "16" ? 16 : 8;
           })
      .choices = bits;
  const auto add_name = [&](const char* name, const char* type, const std::string& text,
                            std::optional<std::string>& out) {
    group.add(name, type, text, [name, &out](const std::string& given) {
      if (given.empty()) throw usage_error(fmt::format("{}: no name; expected one", name));
      out = given;
    });
  };
  add_name(
      "--ocio-view", "VIEW",
      "In place of tone map and transfer: a view of the OpenColorIO configuration in $OCIO, or "
      "'default'",
      options.ocio_view);
  add_name("--ocio-display", "NAME", "The display whose view it is [the configuration's default]",
           options.ocio_display);
  add_name("--ocio-space", "NAME", "A colour space of that configuration, in place of a view",
           options.ocio_space);
  add_name("--ocio-input", "NAME", "The colour space or role of the picture's light [scene_linear]",
           options.ocio_input);
}

const char* colors_of(const v1::Output& of_scene) {
  return of_scene.transfer() == v1::Output::DISPLAY ? "display" : "scene-linear";
}

}  // namespace tessera
