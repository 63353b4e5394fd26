#include "bench/skip.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "bench/error/statistics.h"
#include "bench/thread_seconds.h"
#include "renderer/render/tile_renderer.h"
#include "renderer/scene/read_settings.h"

namespace tessera {
namespace {

struct Shot {
  std::vector<float> values;
  CounterMap counters;
  double seconds = 0;
};

Shot render(const LoadedScene& loaded, const v1::FrameSettings& frame, const Skips& skips) {
  Shot shot;
  const double start = thread_seconds();
  const auto renderer = make_tile_renderer(loaded.scene, loaded.blobs, frame, 1, {}, skips);
  TileProgress progress;
  const PixelRect whole{0, 0, static_cast<int>(frame.width()), static_cast<int>(frame.height())};
  auto tile = renderer->render({whole, 0, frame.samples_per_pixel()}, progress);
  shot.seconds = thread_seconds() - start;
  shot.values = std::move(tile->values);
  shot.counters = renderer->build_counters();
  for (const auto& [name, count] : tile->counters) shot.counters[name] += count;
  return shot;
}

int64_t sum_of(const CounterMap& counters, const std::vector<std::string>& names) {
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

double difference_of(const std::vector<float>& a, const std::vector<float>& b, SkipBound bound) {
  double largest = 0, squares = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const double apart = std::abs(double{a[i]} - double{b[i]});
    largest = std::max(largest, apart / std::max(1.0, std::abs(double{a[i]})));
    squares += apart * apart;
  }
  return bound == SkipBound::rms ? std::sqrt(squares / static_cast<double>(a.size())) : largest;
}

void compare(const Shot& off, const Shot& on, const SkipCase& skip, SkipRow& row) {
  row.same_bits =
      off.values.size() == on.values.size() &&
      std::memcmp(off.values.data(), on.values.data(), off.values.size() * sizeof(float)) == 0;
  row.difference = difference_of(off.values, on.values, skip.bound);
  row.within = row.same_bits || (skip.bound != SkipBound::bits && row.difference <= skip.limit);
  row.skipped = static_cast<uint64_t>(
      std::max<int64_t>(0, sum_of(on.counters, skip.skipped) - sum_of(off.counters, skip.skipped)));
  row.of = static_cast<uint64_t>(std::max<int64_t>(0, sum_of(on.counters, skip.of)));
}

}  // namespace

SkipRow bench_skip(const SkipCase& skip, const SkipBenchOptions& options) {
  const LoadedScene loaded = skip.make();
  v1::FrameSettings frame = complete({}, loaded.scene.settings());
  if (options.quick) {
    frame.set_width(std::max(1u, frame.width() / 4));
    frame.set_height(std::max(1u, frame.height() / 4));
  }
  Skips without;
  without.*skip.skip = false;
  SkipRow row{.name = skip.name, .scene = skip.scene, .bound = skip.bound, .limit = skip.limit};
  compare(render(loaded, frame, without), render(loaded, frame, {}), skip, row);
  std::vector<double> off, on, savings;
  for (int i = 0; i < options.repeats; ++i) {
    off.push_back(render(loaded, frame, without).seconds);
    on.push_back(render(loaded, frame, {}).seconds);
    savings.push_back(1 - on.back() / off.back());
  }
  row.seconds_off = median(std::move(off));
  row.seconds_on = median(std::move(on));
  row.saving = median(std::move(savings));
  return row;
}

std::string skip_table(const std::vector<SkipRow>& rows) {
  std::string text = fmt::format("{:18} {:44} {:>22} {:>12} {:>12} {:>9} {:>9} {:>8}\n", "skip",
                                 "scene", "same bits", "skipped", "of", "off s", "on s", "saving");
  for (const SkipRow& row : rows) {
    const char* measure = row.bound == SkipBound::rms ? "rms " : "";
    const std::string same = row.same_bits
                                 ? "yes"
                                 : fmt::format("{}{:.1e} of {:.0e}{}", measure, row.difference,
                                               row.limit, row.within ? "" : " BEYOND");
    text += fmt::format("{:18} {:44} {:>22} {:12} {:12} {:9.4f} {:9.4f} {:6.1f} %\n", row.name,
                        row.scene, same, row.skipped, row.of, row.seconds_off, row.seconds_on,
                        100 * row.saving);
  }
  return text;
}

std::string skip_json(const std::vector<SkipRow>& rows) {
  constexpr std::array kBounds{"bits", "largest", "rms"};
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const SkipRow& row : rows) {
    list.push_back({{"skip", row.name},
                    {"scene", row.scene},
                    {"same_bits", row.same_bits},
                    {"bound", kBounds[static_cast<size_t>(row.bound)]},
                    {"limit", row.limit},
                    {"difference", row.difference},
                    {"within", row.within},
                    {"skipped", row.skipped},
                    {"of", row.of},
                    {"seconds_off", row.seconds_off},
                    {"seconds_on", row.seconds_on},
                    {"saving", row.saving}});
  }
  return nlohmann::ordered_json{{"rows", list}}.dump(2) + "\n";
}

}  // namespace tessera
