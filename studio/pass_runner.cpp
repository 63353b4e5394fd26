#include "studio/pass_runner.h"

#include <algorithm>
#include <utility>

#include "coordinator/coordinator.h"
#include "front/render_frame.h"
#include "studio/full_frame.h"

namespace tessera {
namespace {

/// The frame of a pass, whose options have its size and samples. Throws Error for options that do
/// not go with the scene.
FullFrame frame_of(const PassOrder& order) {
  RenderOptions options = *order.options;
  const FrameScene& scene = *order.reading->scene;
  const std::optional<int> frame = frame_number(scene, order.reading->frame);
  const FrameRender full(options, scene, frame);
  const v1::FrameSettings& settings = full.settings();
  options.size = FrameSize{scaled_side(static_cast<int>(settings.width()), order.pass.scale),
                           scaled_side(static_cast<int>(settings.height()), order.pass.scale)};
  // The last pass is as the scene and the view want it, adaptive or not.
  if (order.pass.samples < settings.samples_per_pixel()) {
    options.samples_per_pixel = order.pass.samples;
    options.target_error = 0;
    options.min_samples.reset();
    options.denoise = false;
  }
  return {.reading = order.reading,
          .options = std::make_shared<const RenderOptions>(std::move(options)),
          .camera = order.camera,
          .number = frame};
}

uint64_t rays_of(const CounterMap& counters) {
  uint64_t rays = 0;
  for (const auto& [name, count] : counters) {
    if (name.starts_with("rays_")) rays += count;
  }
  return rays;
}

/// The rows of `rect` in a film.
TilePixels cut(const FilmView& film, const PixelRect& rect) {
  TilePixels tile{.rect = rect, .values = {}, .counters = {}, .channels = film.channels};
  const auto channels = static_cast<size_t>(film.channels);
  const size_t row = static_cast<size_t>(rect.width()) * channels;
  tile.values.reserve(row * static_cast<size_t>(rect.height()));
  for (int y = rect.y0; y < rect.y1; ++y) {
    const size_t at =
        (static_cast<size_t>(y - film.rect.y0) * static_cast<size_t>(film.rect.width()) +
         static_cast<size_t>(rect.x0 - film.rect.x0)) *
        channels;
    const auto values = film.values.subspan(at, row);
    tile.values.insert(tile.values.end(), values.begin(), values.end());
  }
  return tile;
}

}  // namespace

void PassRunner::start(Coordinator& coordinator, const PassOrder& order, Time now) {
  try {
    auto frame = std::make_shared<const FullFrame>(frame_of(order));
    JobSpec job = job_of(*frame);
    job.priority = order.priority;
    const AovSet aovs(job.frame.aovs());
    const uint64_t id = coordinator.submit(std::move(job), now);
    running_.emplace(order.serial, Running{.job = id,
                                           .begun = now,
                                           .aovs = aovs,
                                           .told = {},
                                           .next_progress = now + kTellProgress,
                                           .frame = std::move(frame)});
  } catch (const Error& error) {
    events_.end({.serial = order.serial, .how = PassEnd::How::failed, .why = error});
  }
}

void PassRunner::interrupt(Coordinator& coordinator, uint32_t serial, Time now) {
  const auto at = running_.find(serial);
  if (at == running_.end()) return;
  coordinator.interrupt(at->second.job, now);
  coordinator.take_result(at->second.job);
  running_.erase(at);
}

void PassRunner::look(Coordinator& coordinator, Time now) {
  for (auto at = running_.begin(); at != running_.end();) {
    auto& [serial, running] = *at;
    if (auto result = coordinator.take_result(running.job)) {
      pass_on_end(serial, running, std::move(*result), now);
      at = running_.erase(at);
      continue;
    }
    pass_on_tiles(coordinator, serial, running, now);
    ++at;
  }
}

void PassRunner::pass_on_tiles(Coordinator& coordinator, uint32_t serial, Running& running,
                               Time now) {
  const auto film = coordinator.film(running.job);
  if (film) {
    PassTiles done{
        .serial = serial, .film = film->rect, .aovs = running.aovs, .tiles = {}, .workers = {}};
    const auto tiles = coordinator.tiles(running.job, now);
    running.told.resize(tiles.size());
    for (size_t i = 0; i < tiles.size(); ++i) {
      if (running.told[i] || tiles[i].state != TileSnapshot::State::done) continue;
      running.told[i] = true;
      done.tiles.push_back(cut(*film, tiles[i].rect));
      done.workers.push_back(tiles[i].worker);
    }
    if (!done.tiles.empty()) events_.tiles(std::move(done));
  }
  if (now >= running.next_progress) {
    running.next_progress = now + kTellProgress;
    if (const auto progress = coordinator.progress(running.job, now))
      events_.progress(serial, *progress);
  }
}

void PassRunner::pass_on_end(uint32_t serial, const Running& running, JobResult result, Time now) {
  const JobReport& report = result.report;
  PassEnd end{.serial = serial};
  end.trace = report.trace_seconds;
  end.overhead = std::max(0.0, to_seconds(now - running.begun) - end.trace);
  end.rays = rays_of(report.counters);
  switch (report.end) {
    case JobReport::End::interrupted:
      end.how = PassEnd::How::interrupted;
      break;
    case JobReport::End::failed:
      end.how = PassEnd::How::failed;
      end.why = Error(report.exit_code, report.failure);
      break;
    default:
      end.film = std::make_shared<const Film>(std::move(result.film));
      end.frame = running.frame;
  }
  events_.end(std::move(end));
}

}  // namespace tessera
