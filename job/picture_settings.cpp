#include "job/picture_settings.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"

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

}  // namespace

OutputSettings picture_settings(const v1::Output& output) {
  OutputSettings result;
  result.tone_curve = tone_curve(output.tone_map());
  result.transfer = transfer_curve(output.transfer());
  if (output.has_gamma()) result.gamma = output.gamma();
  if (!(result.gamma > 0 && std::isfinite(result.gamma))) {
    throw scene_error(fmt::format("settings: output.gamma is {}; expected above 0", result.gamma));
  }
  result.exposure = output.exposure();
  if (output.quantization() == v1::Output::TRUNCATE) result.quantization = Quantization::truncate;
  if (output.response_size() == 3) {
    result.has_response = true;
    for (int i = 0; i < 3; ++i) result.response[static_cast<size_t>(i)] = output.response(i);
  } else if (output.response_size() != 0) {
    throw scene_error(fmt::format("settings: output.response has {} numbers; expected 3 or none",
                                  output.response_size()));
  }
  return result;
}

}  // namespace tessera
