#include "job/check_job.h"

#include <fmt/format.h>

#include "job/tile_grid.h"
#include "proto/wire/pixels.h"

namespace tessera {
namespace {

/// Films with much beside light must still fit an image file, and a row of a tile one message.
void check_aovs(const JobSpec& spec) {
  if (!AovSet::knows(spec.frame.aovs())) {
    throw usage_error(fmt::format("AOVs of the bits {:#x}; expected some of {:#x}",
                                  spec.frame.aovs(), AovSet(~uint32_t{0}).bits()));
  }
  const int channels = AovSet(spec.frame.aovs()).channels();
  if (channels == kFilmChannels) return;
  constexpr int64_t kMostValues = 4 * kMaxFramePixels;
  if (spec.crop.area() * channels > kMostValues) {
    throw usage_error(fmt::format("{} pixels of {} channels; expected at most {} numbers",
                                  spec.crop.area(), channels, kMostValues));
  }
  const int most_side = static_cast<int>(kBandBytes / sizeof(float)) / channels;
  if (spec.tile_size > most_side) {
    throw usage_error(
        fmt::format("tiles of {} pixels a side, {} channels each; expected at most {}",
                    spec.tile_size, channels, most_side));
  }
}

}  // namespace

void check_job(const JobSpec& spec) {
  const int64_t width = spec.frame.width(), height = spec.frame.height();
  if (width < 1 || height < 1 || width > kMaxFrameSide || height > kMaxFrameSide ||
      width * height > kMaxFramePixels) {
    throw usage_error(
        fmt::format("a frame of {}x{} pixels; expected sides of 1 to {} and at most {} "
                    "pixels",
                    width, height, kMaxFrameSide, kMaxFramePixels));
  }
  const PixelRect frame{0, 0, static_cast<int>(width), static_cast<int>(height)};
  const PixelRect& crop = spec.crop;
  if (crop.empty() || !frame.contains(crop)) {
    throw usage_error(fmt::format("crop {},{},{},{}; expected X0 < X1 <= {} and Y0 < Y1 <= {}",
                                  crop.x0, crop.y0, crop.x1, crop.y1, width, height));
  }
  if (spec.frame.samples_per_pixel() < 1) {
    throw usage_error("0 samples per pixel; expected at least 1");
  }
  check_aovs(spec);
  if (spec.priority < -kMostPriority || spec.priority > kMostPriority) {
    throw usage_error(fmt::format("priority {}; expected a number from {} to {}", spec.priority,
                                  -kMostPriority, kMostPriority));
  }
  // Their names must fit into one message.
  constexpr size_t kMaxBlobs = 16384;
  if (spec.blobs.size() > kMaxBlobs) {
    throw scene_error(
        fmt::format("a scene of {} blobs; expected at most {}", spec.blobs.size(), kMaxBlobs));
  }
  if (spec.tile_size != 0) check_tile_size(crop, spec.tile_size);
}

}  // namespace tessera
