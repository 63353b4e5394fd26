#include "studio/picture_comparison.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "metrics/difference.h"
#include "metrics/picture_error.h"
#include "metrics/ssim.h"
#include "studio/channel_view.h"
#include "studio/page_answer.h"
#include "studio/pixel_frame.h"

namespace tessera {
namespace {

/// Red, green and blue alone.
Picture light_of(const Film& film) {
  const Film light = film.with_only({});
  const auto values = light.values();
  return {film.width(), film.height(), {values.begin(), values.end()}};
}

Difference light_difference(const Picture& a, const Picture& b) {
  return difference_of(a.values, b.values, kFilmChannels, static_cast<size_t>(a.width));
}

}  // namespace

SendText pinned_answer(const PinPicture& order, const Film* film) {
  nlohmann::json fields{{"pane", order.view.pane}};
  if (film) {
    fields["size"] = {film->width(), film->height()};
  } else if (order.what != page::Pin::What::none) {
    const bool is_before = order.what == page::Pin::What::before;
    return refusal(order.view.client, "pin", "",
                   is_before ? "no picture of the scene as it was before is there"
                             : "no whole picture is shown yet");
  }
  return page_answer(order.view.client, "pinned", std::move(fields));
}

nlohmann::json comparison_json(const Film& picture, const Film& reference) {
  if (picture.rect() != reference.rect()) {
    return {{"why", fmt::format("sizes differ: {}x{} is shown, {}x{} is pinned; pin it anew",
                                picture.width(), picture.height(), reference.width(),
                                reference.height())}};
  }
  const Picture a = light_of(picture), b = light_of(reference);
  const Difference difference = light_difference(a, b);
  const PictureError error = picture_error(a, b);
  nlohmann::json fields{{"width", a.width},
                        {"height", a.height},
                        {"max_difference", difference.greatest},
                        {"mean_difference", difference.mean},
                        {"rmse", difference.rmse},
                        {"differing_pixels", difference.pixels_unequal},
                        {"rel_mse", error.rel_mse},
                        {"smape", error.smape},
                        {"flip", error.flip},
                        {"ssim", mean_ssim(a, b)},
                        {"within", error.error_99_9},
                        {"mean_ratio", error.mean_ratio}};
  if (difference.pixels_unequal > 0) {
    const auto width = static_cast<size_t>(a.width);
    fields["worst_pixel"] = {difference.worst_pixel % width, difference.worst_pixel / width};
  }
  return fields;
}

std::vector<uint8_t> difference_pixels(const Film& picture, const Film& reference) {
  const Picture a = light_of(picture), b = light_of(reference);
  const double greatest = light_difference(a, b).greatest;
  std::vector<uint8_t> rgba;
  rgba.reserve(4 * a.pixels());
  for (size_t at = 0; at < a.values.size(); at += kFilmChannels) {
    double difference = 0;
    for (size_t i = at; i < at + kFilmChannels; ++i)
      difference = std::max(difference, channel_difference(a.values[i], b.values[i]));
    std::array<uint8_t, 3> color{};
    // Differences differ by magnitudes, which a root tells apart.
    if (difference > 0)
      color = scale_color(std::isfinite(greatest) ? std::sqrt(difference / greatest) : 1);
    rgba.insert(rgba.end(), {color[0], color[1], color[2], uint8_t{255}});
  }
  return rgba;
}

bool PictureComparer::compare(const ComparePictures& order,
                              const std::optional<PictureStream::Pair>& pair) {
  nlohmann::json fields{{"why", "nothing is pinned, or no whole picture is shown yet"}};
  if (pair) fields = comparison_json(*pair->shown, *pair->pinned);
  fields["pane"] = order.view.pane;
  if (pair) fields["serial"] = pair->serial;
  if (!fields.contains("why")) {
    const PixelRect& rect = pair->shown->rect();
    const PixelFrame frame{.kind = PixelFrame::Kind::difference,
                           .pane = static_cast<uint8_t>(order.view.pane),
                           .serial = ++number_,
                           .rect = rect,
                           .picture_width = static_cast<uint16_t>(rect.width()),
                           .picture_height = static_cast<uint16_t>(rect.height()),
                           .flags = PixelFrame::kLastPieceOfPass};
    const auto sink = sink_of_(order.view.client);
    fields["drawn"] = sink != nullptr;
    BandQueue& waiting = waiting_[order.view];
    waiting.clear();
    waiting.add(frame, pixels_of(difference_pixels(*pair->shown, *pair->pinned), rect.width()),
                order.deflate);
  }
  send_(page_answer(order.view.client, "compared", std::move(fields)));
  return catch_up();
}

}  // namespace tessera
