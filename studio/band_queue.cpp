#include "studio/band_queue.h"

#include <algorithm>
#include <utility>

namespace tessera {
namespace {

constexpr size_t kBytesPerPixel = 4;

}  // namespace

void BandQueue::add(const PixelFrame& frame, const Pixels& pixels, bool deflate) {
  const PixelRect& all = frame.rect;
  const size_t row_bytes = kBytesPerPixel * static_cast<size_t>(std::max(all.width(), 1));
  const int rows = static_cast<int>(std::max(kMostBytes / row_bytes, size_t{1}));
  int y = all.y0;
  do {
    Band band{frame, pixels, deflate};
    band.frame.rect = {all.x0, y, all.x1, std::min(y + rows, all.y1)};
    y += rows;
    if (y < all.y1) band.frame.flags = 0;
    const bool is_band = band.frame.rect != all;
    if (is_band && frame.kind == PixelFrame::Kind::whole) band.frame.kind = PixelFrame::Kind::tile;
    bands_.push_back(std::move(band));
  } while (y < all.y1);
}

void BandQueue::clear() {
  bands_.clear();
  encoded_.reset();
}

bool BandQueue::send(PixelSink* sink) {
  if (!sink) clear();
  while (!bands_.empty()) {
    const auto& [frame, pixels, deflate] = bands_.front();
    if (!encoded_) {
      const auto bytes = frame.rect.empty() ? std::vector<uint8_t>() : pixels(frame.rect);
      encoded_ = std::make_shared<const std::string>(
          encode_pixel_frame(frame, bytes, deflate && !bytes.empty()));
    }
    if (!sink->send(encoded_)) return false;
    encoded_.reset();
    bands_.pop_front();
  }
  return true;
}

BandQueue::Pixels pixels_of(std::vector<uint8_t> bytes, int width) {
  return [all = std::make_shared<const std::vector<uint8_t>>(std::move(bytes)),
          row = kBytesPerPixel * static_cast<size_t>(width)](const PixelRect& rect) {
    const auto at = [&](int y) {
      return all->begin() + static_cast<std::ptrdiff_t>(static_cast<size_t>(y) * row);
    };
    return std::vector<uint8_t>(at(rect.y0), at(rect.y1));
  };
}

}  // namespace tessera
