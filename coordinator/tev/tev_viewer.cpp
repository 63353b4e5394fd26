#include "coordinator/tev/tev_viewer.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "base/process_usage.h"
#include "coordinator/coordinator.h"
#include "coordinator/tev/tev_message.h"

namespace tessera {
namespace {

/// So many are remembered of those that have ended before the viewer took them.
constexpr size_t kMostFrames = 16;
constexpr Time kBetweenLooks = std::chrono::milliseconds(100);

std::vector<float> values_of(const FilmView& film, const PixelRect& rect) {
  std::vector<float> values;
  values.reserve(static_cast<size_t>(rect.area()) * kFilmChannels);
  for (int y = rect.y0; y < rect.y1; ++y) {
    const auto row = static_cast<size_t>(y - film.rect.y0) * static_cast<size_t>(film.rect.width());
    const size_t first = row + static_cast<size_t>(rect.x0 - film.rect.x0);
    for (size_t pixel = first; pixel < first + static_cast<size_t>(rect.width()); ++pixel) {
      const auto light =
          film.values.subspan(pixel * static_cast<size_t>(film.channels), kFilmChannels);
      values.insert(values.end(), light.begin(), light.end());
    }
  }
  return values;
}

}  // namespace

void TevViewer::look(Coordinator& coordinator, Time now) {
  const uint64_t connections = link_.connections();
  if (connections == 0 || now < next_look_) return;
  const Time start = thread_time();
  if (connections != connections_) {
    connections_ = connections;
    for (auto& [key, shown] : frames_) {
      shown.created = false;
      shown.sent.assign(shown.sent.size(), false);
    }
  }
  show_ended(coordinator);
  show_running(coordinator, now);
  next_look_ = now + std::max<Time>(kBetweenLooks, 50 * (thread_time() - start));
}

void TevViewer::show_running(Coordinator& coordinator, Time now) {
  for (const FrameKey& key : coordinator.running_frames()) {
    Shown& shown = frames_[key];
    const auto tiles = coordinator.tiles(key.first, key.second, now);
    if (shown.tiles.empty()) {
      shown.name =
          fmt::format("job {} frame {}", key.first, coordinator.number_of(key.first, key.second));
      for (const TileSnapshot& tile : tiles) shown.tiles.push_back(tile.rect);
      shown.sent.resize(tiles.size());
      shown.done.resize(tiles.size());
    }
    for (size_t i = 0; i < tiles.size(); ++i) {
      shown.done[i] = tiles[i].state == TileSnapshot::State::done;
      // Where its pixels did not count after all, it is sent again.
      if (!shown.done[i]) shown.sent[i] = false;
    }
    if (const auto film = coordinator.film(key.first, key.second)) send(shown, *film);
  }
}

void TevViewer::show_ended(Coordinator& coordinator) {
  const auto running = coordinator.running_frames();
  const std::set<FrameKey> live(running.begin(), running.end());
  for (auto it = frames_.begin(); it != frames_.end();) {
    bool over = false;
    if (!live.contains(it->first)) {
      Shown& shown = it->second;
      shown.done.assign(shown.done.size(), true);
      const auto film = coordinator.film(it->first.first, it->first.second);
      over = !film || send(shown, *film) || frames_.size() > kMostFrames;
    }
    it = over ? frames_.erase(it) : std::next(it);
  }
}

void TevViewer::finish(const Film& film) {
  if (link_.connections() == 0) return;
  Shown last;
  for (auto& [key, shown] : frames_) last = std::move(shown);
  frames_.clear();
  if (last.name.empty()) last = {"picture", false, {film.rect()}, {false}, {true}};
  last.done.assign(last.tiles.size(), true);
  // Waits for the viewer, but not for one that does not take it.
  for (const Time end = monotonic_now() + std::chrono::seconds(1); monotonic_now() < end;) {
    if (send(last, {film.rect(), film.channels(), film.values(), nullptr})) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

bool TevViewer::send(Shown& shown, const FilmView& film) {
  const PixelRect& whole = film.rect;
  if (!shown.created) {
    shown.created = link_.offer(tev_create_image(shown.name, whole.width(), whole.height()));
    if (!shown.created) return false;
  }
  for (size_t i = 0; i < shown.tiles.size(); ++i) {
    if (!shown.done[i] || shown.sent[i]) continue;
    const PixelRect& tile = shown.tiles[i];
    const PixelRect place = {tile.x0 - whole.x0, tile.y0 - whole.y0, tile.x1 - whole.x0,
                             tile.y1 - whole.y0};
    shown.sent[i] = link_.offer(tev_update_image(shown.name, place, values_of(film, tile)));
    if (!shown.sent[i]) return false;
  }
  return true;
}

}  // namespace tessera
