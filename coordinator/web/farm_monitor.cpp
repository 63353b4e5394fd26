#include "coordinator/web/farm_monitor.h"

#include <algorithm>
#include <iterator>
#include <optional>

#include "base/process_usage.h"
#include "coordinator/coordinator.h"

namespace tessera {
namespace {

constexpr Time kBetweenSnapshots = std::chrono::milliseconds(250);
constexpr Time kBetweenSamples = std::chrono::seconds(1);
constexpr size_t kSamples = 600;
constexpr Time kBetweenTiles = std::chrono::milliseconds(250);
constexpr Time kBetweenPreviews = std::chrono::milliseconds(500);
/// Of first pictures, one a frame: a tenth of the processor.
constexpr int kFirstShare = 10;
constexpr int kPreviewSide = 1024;
/// Less than the server's patience for an answer.
constexpr Time kNewsPatience = std::chrono::seconds(3);
/// A frame is shown for so long after it was last asked for.
constexpr Time kWatched = std::chrono::seconds(10);
constexpr size_t kMostWatched = 16;
constexpr size_t kMostWaiting = 1024;
/// For news, each on a connection of the 512 that there are: others have to get through.
constexpr size_t kMostListening = 256;
/// Orders that are carried out in one look: each may write to the store, and wait for the disk.
constexpr size_t kOrdersOfLook = 4;

/// When what took `spent` of the processor may be done again: each kind takes at most a fiftieth.
Time next_after(Time now, Time spent, Time least) { return now + std::max(least, 50 * spent); }

/// Whether the picture has all tiles that a frame being traced has by now.
bool is_up_to_date(const FrameShown& shown) {
  if (!shown.preview || shown.tiles.empty()) return false;
  const auto done = std::count_if(shown.tiles.begin(), shown.tiles.end(), [](const auto& tile) {
    return tile.state == TileSnapshot::State::done;
  });
  return shown.preview->tiles_done == static_cast<uint64_t>(done);
}

}  // namespace

std::shared_ptr<const FarmShown> FarmMonitor::farm() const {
  const std::scoped_lock lock(mutex_);
  return farm_;
}

Time FarmMonitor::last_look() const {
  const std::scoped_lock lock(mutex_);
  return last_look_;
}

FarmMonitor::Work FarmMonitor::work() const {
  const std::scoped_lock lock(mutex_);
  return work_;
}

bool FarmMonitor::watch(uint64_t job, uint32_t frame, FrameReply reply) {
  const std::scoped_lock lock(mutex_);
  if (inbox_.frames.size() >= kMostWaiting) return false;
  inbox_.frames.push_back({{job, frame}, std::move(reply)});
  return true;
}

bool FarmMonitor::ask(Question question) {
  const std::scoped_lock lock(mutex_);
  if (inbox_.questions.size() >= kMostWaiting) return false;
  inbox_.questions.push_back(std::move(question));
  return true;
}

bool FarmMonitor::order(v1::JobQuery query, OrderReply reply) {
  const std::scoped_lock lock(mutex_);
  if (inbox_.orders.size() >= kMostWaiting) return false;
  inbox_.orders.push_back({std::move(query), std::move(reply)});
  return true;
}

bool FarmMonitor::ask_news(uint64_t known, NewsReply reply) {
  const std::scoped_lock lock(mutex_);
  if (inbox_.news.size() >= kMostListening) return false;
  inbox_.news.push_back({known, std::nullopt, std::move(reply)});
  return true;
}

void FarmMonitor::look(Coordinator& coordinator, Time now) {
  std::vector<Order> orders;
  std::vector<FrameQuestion> questions;
  Question question;
  {
    const std::scoped_lock lock(mutex_);
    last_look_ = now;
    ++work_.looks;
    const size_t due = now >= next_orders_ ? std::min(inbox_.orders.size(), kOrdersOfLook) : 0;
    work_.orders += due;
    const auto end = inbox_.orders.begin() + static_cast<ptrdiff_t>(due);
    std::move(inbox_.orders.begin(), end, std::back_inserter(orders));
    inbox_.orders.erase(inbox_.orders.begin(), end);
    questions.swap(inbox_.frames);
    if (!inbox_.questions.empty() && now >= next_question_) {
      question = std::move(inbox_.questions.front());
      inbox_.questions.erase(inbox_.questions.begin());
    }
  }
  if (!orders.empty()) {
    carry_out(std::move(orders), coordinator, now);
  } else if (now >= next_snapshot_ || (now >= next_news_ && coordinator.news() != news_)) {
    show_farm(coordinator, now);
  }
  tell_news(now);
  note_watchers(std::move(questions), now);
  show_tiles(coordinator, now);
  show_oldest_preview(coordinator, now);
  tell_watchers();
  if (!question) return;
  const Time start = thread_time();
  question(coordinator, now);
  next_question_ = next_after(now, thread_time() - start, Time{0});
}

// ------------------------------------------------------------------------------------- the farm

void FarmMonitor::carry_out(std::vector<Order> orders, Coordinator& coordinator, Time now) {
  // Of the clock, not of the processor: whoever waits for the disk keeps the thread as well.
  const Time start = monotonic_now();
  for (const Order& order : orders) order.reply(coordinator.ask(order.query, now));
  // Who ordered something wants to see it done.
  show_farm(coordinator, now);
  constexpr int kShare = 10;
  next_orders_ = now + kShare * (monotonic_now() - start);
}

void FarmMonitor::show_farm(const Coordinator& coordinator, Time now) {
  const Time start = thread_time();
  auto shown = std::make_shared<FarmShown>();
  news_ = coordinator.news();
  shown->snapshot = coordinator.snapshot(now);
  if (now >= next_sample_) sample(shown->snapshot, now);
  shown->history = history_;
  const std::scoped_lock lock(mutex_);
  farm_ = std::move(shown);
  ++work_.snapshots;
  next_news_ = next_after(now, thread_time() - start, Time{0});
  next_snapshot_ = std::max(next_news_, now + kBetweenSnapshots);
}

void FarmMonitor::tell_news(Time now) {
  std::vector<NewsReply> replies;
  {
    const std::scoped_lock lock(mutex_);
    std::erase_if(inbox_.news, [&](NewsQuestion& question) {
      if (!question.until) question.until = now + kNewsPatience;
      if (question.known == news_ && now < *question.until) return false;
      replies.push_back(std::move(question.reply));
      return true;
    });
  }
  for (const NewsReply& reply : replies) reply(news_);
}

void FarmMonitor::sample(const FarmSnapshot& snapshot, Time now) {
  next_sample_ = now + kBetweenSamples;
  FarmSample sample{.at = snapshot.uptime_seconds};
  for (const FarmSnapshot::Worker& worker : snapshot.workers) {
    if (worker.state == FarmSnapshot::WorkerState::lost) continue;
    ++sample.workers;
    sample.threads += worker.threads;
    sample.tiles_held += worker.tiles_held;
    sample.worker_bytes += worker.resident_bytes;
  }
  sample.coordinator_bytes = process_usage().resident_bytes;
  const FarmSnapshot::Counters& counters = snapshot.counters;
  if (const double seconds = sample.at - sampled_at_; seconds > 0) {
    const auto rate = [seconds](uint64_t before, uint64_t after) {
      return static_cast<double>(after - before) / seconds;
    };
    sample.tiles_per_second = rate(sampled_.tiles_done, counters.tiles_done);
    sample.result_bytes_per_second = rate(sampled_.bytes_results, counters.bytes_results);
  }
  sampled_ = counters;
  sampled_at_ = sample.at;
  auto history = history_ ? *history_ : std::vector<FarmSample>();
  if (history.size() >= kSamples) history.erase(history.begin());
  history.push_back(sample);
  history_ = std::make_shared<const std::vector<FarmSample>>(std::move(history));
}

// --------------------------------------------------------------------------------------- frames

void FarmMonitor::note_watchers(std::vector<FrameQuestion> questions, Time now) {
  std::erase_if(watched_,
                [now](const auto& entry) { return now - entry.second.wanted > kWatched; });
  for (FrameQuestion& question : questions) {
    if (!watched_.contains(question.key) && !make_room()) {
      question.reply(std::make_shared<FrameShown>());
      continue;
    }
    Watched& watched = watched_[question.key];
    watched.wanted = now;
    watched.waiting.push_back(std::move(question.reply));
  }
}

bool FarmMonitor::make_room() {
  if (watched_.size() < kMostWatched) return true;
  const auto oldest = std::min_element(watched_.begin(), watched_.end(), [](auto& a, auto& b) {
    return std::pair(!a.second.waiting.empty(), a.second.wanted) <
           std::pair(!b.second.waiting.empty(), b.second.wanted);
  });
  if (!oldest->second.waiting.empty()) return false;
  watched_.erase(oldest);
  return true;
}

void FarmMonitor::show_tiles(Coordinator& coordinator, Time now) {
  for (auto& [key, watched] : watched_) {
    if (now < watched.next_tiles) continue;
    const Time start = thread_time();
    auto shown = std::make_shared<FrameShown>();
    shown->number = coordinator.number_of(key.first, key.second);
    shown->tiles = coordinator.tiles(key.first, key.second, now);
    shown->preview = watched.shown->preview;
    shown->pictured = watched.shown->pictured;
    // It may have been put aside, or ended too early.
    if (!shown->tiles.empty()) watched.preview_is_final = false;
    watched.shown = std::move(shown);
    watched.next_tiles = next_after(now, thread_time() - start, kBetweenTiles);
    const std::scoped_lock lock(mutex_);
    ++work_.tile_lists;
  }
}

void FarmMonitor::show_oldest_preview(Coordinator& coordinator, Time now) {
  const std::pair<const FrameKey, Watched>* oldest = nullptr;
  for (const auto& entry : watched_) {
    const Watched& watched = entry.second;
    if (watched.preview_is_final || is_up_to_date(*watched.shown)) continue;
    if (now < (watched.shown->preview ? next_preview_ : next_first_preview_)) continue;
    if (!oldest || watched.previewed < oldest->second.previewed) oldest = &entry;
  }
  if (!oldest) return;
  const Time start = thread_time();
  Watched& watched = watched_[oldest->first];
  const auto& [job, frame] = oldest->first;
  watched.previewed = now;
  auto preview = coordinator.preview(job, frame, kPreviewSide);
  if (!preview) {
    // To find that out may have taken long too.
    next_first_preview_ = now + kFirstShare * (thread_time() - start);
    return;
  }
  auto shown = std::make_shared<FrameShown>(*watched.shown);
  shown->tiles = coordinator.tiles(job, frame, now);
  shown->preview = std::make_shared<const PreviewImage>(std::move(*preview));
  std::vector<bool> pictured;
  for (const TileSnapshot& tile : shown->tiles) {
    pictured.push_back(tile.state == TileSnapshot::State::done);
  }
  shown->pictured = std::make_shared<const std::vector<bool>>(std::move(pictured));
  // Of a frame that has ended the picture does not change any more.
  watched.preview_is_final = shown->tiles.empty();
  watched.shown = std::move(shown);
  next_first_preview_ = now + kFirstShare * (thread_time() - start);
  next_preview_ = next_after(now, thread_time() - start, kBetweenPreviews);
  const std::scoped_lock lock(mutex_);
  ++work_.previews;
}

void FarmMonitor::tell_watchers() {
  for (auto& [key, watched] : watched_) {
    for (const FrameReply& reply : watched.waiting) reply(watched.shown);
    watched.waiting.clear();
  }
}

}  // namespace tessera
