#include "bench/skip.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "bench/error/statistics.h"
#include "bench/thread_seconds.h"
#include "renderer/render/tile_renderer.h"
#include "renderer/scene/read_settings.h"

namespace tessera {
namespace {

/// A scene that was built once and is rendered many times.
class BuiltScene {
 public:
  BuiltScene(const LoadedScene& loaded, const v1::FrameSettings& frame)
      : whole_{0, 0, static_cast<int>(frame.width()), static_cast<int>(frame.height())},
        samples_(frame.samples_per_pixel()),
        renderer_(make_tile_renderer(loaded.scene, loaded.blobs, frame, 1)) {}

  TilePixels render(double& seconds) const {
    TileProgress progress;
    const double start = thread_seconds();
    auto tile = renderer_->render({whole_, 0, samples_}, progress);
    seconds = thread_seconds() - start;
    return std::move(*tile);
  }
  int64_t sum_of(const std::vector<std::string>& names, const TilePixels& tile) const {
    CounterMap counters = renderer_->build_counters();
    for (const auto& [name, count] : tile.counters) counters[name] += count;
    int64_t sum = 0;
    for (const std::string& name : names) {
      const bool is_negative = name.starts_with('-');
      const auto found = counters.find(is_negative ? name.substr(1) : name);
      if (found == counters.end()) continue;
      const auto count = static_cast<int64_t>(found->second);
      sum += is_negative ? -count : count;
    }
    return sum;
  }

 private:
  PixelRect whole_;
  uint32_t samples_;
  std::shared_ptr<const TileRenderer> renderer_;
};

}  // namespace

SkipRow bench_skip(const UnneededKind& kind, const SkipBenchOptions& options) {
  LoadedScene loaded = skip_bench_scene();
  v1::FrameSettings frame = complete({}, loaded.scene.settings());
  if (options.quick) {
    frame.set_width(std::max(1u, frame.width() / 4));
    frame.set_height(std::max(1u, frame.height() / 4));
  }
  const BuiltScene without(loaded, frame);
  kind.add(loaded);
  const BuiltScene with(loaded, frame);

  SkipRow row{.name = kind.name, .description = kind.description};
  double seconds = 0, seconds_with = 0;
  const TilePixels tile = without.render(seconds), tile_with = with.render(seconds_with);
  row.same_bits = tile.values == tile_with.values;
  row.left_out = with.sum_of(kind.counters, tile_with) - without.sum_of(kind.counters, tile);
  std::vector<double> all, all_with, ratios;
  for (int i = 0; i < options.repeats; ++i) {
    without.render(seconds);
    with.render(seconds_with);
    all.push_back(seconds);
    all_with.push_back(seconds_with);
    ratios.push_back(seconds_with / seconds);
  }
  row.seconds = median(std::move(all));
  row.seconds_with = median(std::move(all_with));
  row.ratio = median(std::move(ratios));
  return row;
}

std::string skip_table(const std::vector<SkipRow>& rows) {
  std::string text =
      fmt::format("{:20} {:44} {:>9} {:>10} {:>9} {:>9} {:>7}\n", "unneeded", "a thousand of these",
                  "same bits", "left out", "s without", "s with", "ratio");
  for (const SkipRow& row : rows) {
    text += fmt::format("{:20} {:44} {:>9} {:10} {:9.4f} {:9.4f} {:7.3f}{}\n", row.name,
                        row.description, row.same_bits ? "yes" : "NO", row.left_out, row.seconds,
                        row.seconds_with, row.ratio, row.ratio > kMostSkipRatio ? " BEYOND" : "");
  }
  return text;
}

std::string skip_json(const std::vector<SkipRow>& rows) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const SkipRow& row : rows) {
    list.push_back({{"unneeded", row.name},
                    {"description", row.description},
                    {"same_bits", row.same_bits},
                    {"left_out", row.left_out},
                    {"seconds_without", row.seconds},
                    {"seconds_with", row.seconds_with},
                    {"ratio", row.ratio}});
  }
  return nlohmann::ordered_json{{"rows", list}}.dump(2) + "\n";
}

}  // namespace tessera
