#include "cli/output_settings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cli/located.h"

namespace tessera {
namespace {

ToneCurve tone_curve(v1::Output::ToneMap tone_map) {
  switch (tone_map) {
    case v1::Output::REINHARD:
      return ToneCurve::reinhard;
    case v1::Output::REINHARD_LUMINANCE:
      return ToneCurve::reinhard_luminance;
    case v1::Output::FILMIC:
      return ToneCurve::filmic;
    case v1::Output::LINEAR:
      return ToneCurve::linear;
    default:
      return ToneCurve::clamp;
  }
}

TransferCurve transfer_curve(v1::Output::Transfer transfer) {
  switch (transfer) {
    case v1::Output::DISPLAY:
      return TransferCurve::display;
    case v1::Output::GAMMA:
      return TransferCurve::gamma;
    default:
      return TransferCurve::srgb;
  }
}

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

void lay_over(const OutputOptions& options, OutputSettings& settings) {
  static constexpr ToneCurve kCurves[] = {ToneCurve::clamp, ToneCurve::reinhard,
                                          ToneCurve::reinhard_luminance, ToneCurve::filmic,
                                          ToneCurve::linear};
  static constexpr TransferCurve kTransfers[] = {TransferCurve::srgb, TransferCurve::display,
                                                 TransferCurve::gamma};
  if (options.tone_map) {
    settings.tone_curve = kCurves[index_of(tone_map_names(), *options.tone_map)];
  }
  if (options.gamma) {
    settings.gamma = *options.gamma;
    settings.transfer = TransferCurve::gamma;
  }
  if (options.transfer) {
    settings.transfer = kTransfers[index_of(transfer_names(), *options.transfer)];
  }
  if (options.exposure) settings.exposure = *options.exposure;
  settings.color_management = color_management(options);
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

OutputSettings output_settings(const std::string& scene_file, const v1::Output& output,
                               const OutputOptions& options) {
  OutputSettings result;
  result.tone_curve = tone_curve(output.tone_map());
  result.transfer = transfer_curve(output.transfer());
  if (output.has_gamma()) result.gamma = output.gamma();
  if (!(result.gamma > 0 && std::isfinite(result.gamma))) {
    throw located(scene_file,
                  fmt::format("settings: output.gamma is {}; expected above 0", result.gamma));
  }
  result.exposure = output.exposure();
  if (output.quantization() == v1::Output::TRUNCATE) result.quantization = Quantization::truncate;
  if (output.response_size() == 3) {
    result.has_response = true;
    for (int i = 0; i < 3; ++i) result.response[static_cast<size_t>(i)] = output.response(i);
  } else if (output.response_size() != 0) {
    throw located(scene_file, fmt::format("settings: output.response has {} numbers; expected 3 "
                                          "or none",
                                          output.response_size()));
  }
  lay_over(options, result);
  return result;
}

}  // namespace tessera
