#include "bench/error_render.h"

#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <filesystem>

#include "base/digest.h"
#include "base/error.h"
#include "base/monotonic.h"
#include "base/parallel.h"
#include "image/image_file.h"
#include "proto/wire/scene_codec.h"
#include "proto/wire/version.h"
#include "renderer/film/film.h"
#include "renderer/render/tile_renderer.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr std::array<uint32_t, 2> kReferenceSeeds{1'000'000'001, 1'000'000'002};

/// Processor time of all threads of this process.
double process_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

std::vector<PixelRect> tiles_of(int width, int height) {
  constexpr int kSide = 16;
  std::vector<PixelRect> out;
  for (int y = 0; y < height; y += kSide)
    for (int x = 0; x < width; x += kSide)
      out.push_back({x, y, std::min(x + kSide, width), std::min(y + kSide, height)});
  return out;
}

/// A file of the cache; none where it is not there, is not whole or has another size.
std::optional<Picture> cached(const fs::path& path, int width, int height) {
  std::error_code none;
  if (!fs::is_regular_file(path, none)) return std::nullopt;
  try {
    Picture picture = read_picture(path.string());
    if (picture.width == width && picture.height == height) return picture;
  } catch (const Error&) {
    // It is made anew.
  }
  return std::nullopt;
}

void keep(const fs::path& path, const Picture& picture, uint32_t samples, uint32_t seed) {
  Film film({0, 0, picture.width, picture.height});
  std::copy(picture.values.begin(), picture.values.end(), film.values().begin());
  ImageMetadata metadata;
  metadata.seed = seed;
  metadata.samples_per_pixel = samples;
  write_image(path, film, {}, metadata);
}

/// What the reference's pixels depend on, but for the number of samples and the seed.
std::string reference_key(const v1::Scene& scene) {
  return Digest::of(serialize_scene(scene) + kNumericsId).hex().substr(0, 32);
}

}  // namespace

v1::Scene with_method(v1::Scene scene, const ErrorMethod& method) {
  v1::Sampling& sampling = *scene.mutable_settings()->mutable_sampling();
  sampling.set_pattern(method.pattern ? static_cast<v1::Sampling::Pattern>(*method.pattern)
                                      : v1::Sampling::OWEN_SOBOL);
  if (method.filter) sampling.set_filter(static_cast<v1::Sampling::Filter>(*method.filter));
  if (!method.is_adaptive) sampling.clear_target_error();
  return scene;
}

ErrorPicture render_shot(const v1::Scene& scene, const BlobStore& blobs, const ErrorMethod& method,
                         const ErrorShot& shot, int threads) {
  const int width = static_cast<int>(scene.settings().width());
  const int height = static_cast<int>(scene.settings().height());
  v1::FrameSettings frame;
  frame.set_samples_per_pixel(shot.samples);
  frame.set_seed(shot.seed);
  frame.set_integrator(method.integrator);
  frame.set_accelerator(method.accelerator);
  v1::Scene aimed;
  if (method.is_adaptive) {
    aimed = scene;
    aimed.mutable_settings()->mutable_sampling()->set_target_error(shot.target_error);
  }
  ErrorPicture out{{width, height, {}}, {}, 0, 0};
  out.picture.values.resize(3 * out.picture.pixels());
  const Time start = monotonic_now();
  const auto renderer =
      make_tile_renderer(method.is_adaptive ? aimed : scene, blobs, frame, threads);
  const Time built = monotonic_now();
  const double cpu_before = process_seconds();
  const std::vector<PixelRect> tiles = tiles_of(width, height);
  std::atomic<uint64_t> samples{0}, not_finite{0};
  for_each_parallel(tiles.size(), threads, [&](size_t i) {
    TileProgress progress;
    const auto tile = renderer->render({tiles[i], 0, shot.samples}, progress);
    const auto row_size = static_cast<std::ptrdiff_t>(tiles[i].width()) * kFilmChannels;
    for (int y = 0; y < tiles[i].height(); ++y)
      std::copy_n(tile->values.begin() + y * row_size, row_size,
                  out.picture.values.begin() +
                      kFilmChannels * (std::ptrdiff_t{tiles[i].y0 + y} * width + tiles[i].x0));
    samples += tile->counters.at("samples");
    not_finite += tile->counters.at("nan_samples");
  });
  out.run.wall_seconds = to_seconds(monotonic_now() - built);
  out.run.cpu_seconds = process_seconds() - cpu_before;
  out.run.build_seconds = to_seconds(built - start);
  out.mean_samples = method.is_adaptive ? static_cast<double>(samples.load()) /
                                              static_cast<double>(out.picture.pixels())
                                        : shot.samples;
  out.not_finite = not_finite;
  return out;
}

Reference converged_reference(const v1::Scene& scene, const BlobStore& blobs, uint32_t& samples,
                              uint32_t most_samples, const std::string& cache_folder, int threads) {
  const int width = static_cast<int>(scene.settings().width());
  const int height = static_cast<int>(scene.settings().height());
  const std::string key = reference_key(scene);
  const auto path = [&](uint32_t count, size_t which) {
    return fs::path(cache_folder) / fmt::format("{}-{}-{}.exr", key, count, which + 1);
  };
  for (uint32_t count = most_samples; count >= samples && !cache_folder.empty(); count /= 2) {
    auto first = cached(path(count, 0), width, height);
    if (!first) continue;
    auto second = cached(path(count, 1), width, height);
    if (!second) continue;
    samples = count;
    return {std::move(*first), std::move(*second)};
  }
  if (!cache_folder.empty()) fs::create_directories(cache_folder);
  std::array<Picture, 2> pictures;
  for (size_t i = 0; i < pictures.size(); ++i) {
    pictures[i] =
        render_shot(scene, blobs, {"reference"}, {samples, kReferenceSeeds[i]}, threads).picture;
    if (!cache_folder.empty()) keep(path(samples, i), pictures[i], samples, kReferenceSeeds[i]);
  }
  return {std::move(pictures[0]), std::move(pictures[1])};
}

Picture read_picture(const std::string& path) {
  const FloatImage image = read_image(path);
  return {image.width, image.height, linear_light(image)};
}

}  // namespace tessera
