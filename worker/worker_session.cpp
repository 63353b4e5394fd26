#include "worker/worker_session.h"

#include <algorithm>
#include <set>
#include <string_view>
#include <utility>

#include "base/process.h"
#include "proto/wire/printable.h"

namespace tessera {
namespace {

constexpr Time kFirstHelloPause = std::chrono::seconds(1);
constexpr Time kLongestHelloPause = std::chrono::seconds(8);
constexpr Time kLongestPause = std::chrono::seconds(1);
// After the end of the one before it, where both come of one decision.
constexpr Time kNextJobComes = std::chrono::milliseconds(5);
// So often a coordinator may say that it has not a blob of the job that it told of.
constexpr int kMostMissed = 3;

Time milliseconds(uint32_t count) {
  return std::chrono::milliseconds(std::clamp<uint32_t>(count, 10, 3600'000));
}

/// The job of a result.
uint64_t job_of(const v1::Envelope& message) {
  return message.has_tile_band() ? message.tile_band().job() : message.tile_failed().job();
}

uint64_t scene_bytes(const v1::JobStart& start) {
  uint64_t sum = start.scene_size();
  for (const uint64_t size : start.blob_sizes()) sum += std::min(size, kMaxBlobBytes);
  return sum;
}

}  // namespace

uint32_t lowered_credit(uint32_t credit, uint32_t threads) {
  return credit > threads && threads > 0 ? threads : std::max<uint32_t>(1, credit / 2);
}

WorkerSession::WorkerSession(SessionOptions options, Time now)
    : options_(std::move(options)),
      silence_(now),
      next_look_(now),
      next_hello_(now),
      hello_pause_(kFirstHelloPause),
      cache_(options_.blob_sources) {
  on_tick(now);
}

v1::Envelope& WorkerSession::send(Channel channel) {
  actions_.push_back(SendMessage{channel, {}});
  return std::get<SendMessage>(actions_.back()).message;
}

std::vector<SessionAction> WorkerSession::take_actions() { return std::exchange(actions_, {}); }

void WorkerSession::say_hello(Time now) {
  welcomed_ = false;
  options_.hello.set_session(options_.hello.session() + 1);
  *send().mutable_hello() = options_.hello;
  // Workers that lost one coordinator must not all come back in the same moment.
  const uint64_t mixed =
      (options_.hello.worker_id() ^ options_.hello.session()) * 0x9e3779b97f4a7c15;
  next_hello_ = now + hello_pause_;
  if (options_.hello.session() > 1) {
    next_hello_ += hello_pause_ / 4 * static_cast<int64_t>(mixed >> 56) / 256;
  }
  hello_pause_ = std::min(hello_pause_ * 2, kLongestHelloPause);
}

void WorkerSession::drain(Time now) {
  leaves_ = true;
  std::erase_if(runs_, [](const auto& entry) {
    if (entry.second->started) return false;
    entry.second->progress.cancelled = true;
    return true;
  });
  if (welcomed_) send_heartbeat(now);
}

void WorkerSession::leave(const std::string& reason) {
  for (auto& [lease, run] : runs_) run->progress.cancelled = true;
  runs_.clear();
  for (auto& [id, job] : jobs_) *job.dropped = true;
  for (OrphanedBuild& build : orphaned_builds_) *build.dropped = true;
  v1::Bye& bye = *send().mutable_bye();
  bye.set_session(options_.hello.session());
  bye.set_reason(reason);
}

void WorkerSession::cancel_runs(uint64_t job) {
  std::erase_if(runs_, [job](const auto& entry) {
    if (entry.first.first != job) return false;
    entry.second->progress.cancelled = true;
    return true;
  });
}

void WorkerSession::drop_builds() {
  next_drop_ = Time::max();
  if (orphaned_builds_.empty()) return;
  std::erase_if(orphaned_builds_, [this](const OrphanedBuild& build) {
    const auto& blobs = build.start.blobs();
    const bool wanted = std::ranges::any_of(jobs_, [&blobs](const auto& entry) {
      const Job& job = entry.second;
      if (job.renderer || job.bad() || blobs.empty()) return false;
      const std::set<std::string_view> needed(job.start.blobs().begin(), job.start.blobs().end());
      return std::ranges::all_of(blobs, [&](const auto& blob) { return needed.contains(blob); });
    });
    if (!wanted) *build.dropped = true;
    return !wanted;
  });
}

void WorkerSession::forget_job(uint64_t job) {
  cancel_runs(job);
  if (const auto it = jobs_.find(job); it != jobs_.end()) {
    Job& over = it->second;
    if (over.building && over.run->started) {
      orphaned_builds_.push_back({over.start, over.run, over.dropped});
      next_drop_ = silence_.reaches(kNextJobComes);
    } else {
      *over.dropped = true;
    }
    jobs_.erase(it);
  }
  forget_results([job](const Result& result) { return job_of(result.message) == job; });
}

void WorkerSession::forget_jobs() {
  while (!jobs_.empty()) forget_job(jobs_.begin()->first);
  missed_.clear();
}

// -------------------------------------------------------------------------------------- messages

void WorkerSession::on_message(Channel channel, const v1::Envelope& message, Time now) {
  if (channel == Channel::bulk) return on_bulk(message, now);
  silence_.heard(now);
  switch (message.message_case()) {
    case v1::Envelope::kWelcome:
      return on_welcome(message.welcome(), now);
    case v1::Envelope::kReject:
      // The answer to a hello that has been followed by another.
      if (const uint64_t of = message.reject().session();
          of != 0 && of != options_.hello.session()) {
        return;
      }
      forget_results([](const Result&) { return true; });
      actions_.push_back(Quit{message.reject().reason() == v1::Reject::QUARANTINED ||
                                      message.reject().reason() == v1::Reject::ID_TAKEN
                                  ? ExitCode::render_failed
                                  : ExitCode::bad_usage,
                              "refused by the coordinator: " + printable(message.reject().text()),
                              true});
      return;
    case v1::Envelope::kHelloRequest:
      // Requests answer every message that crossed the hello; one hello answers them all.
      if (welcomed_) {
        hello_pause_ = kFirstHelloPause;
        say_hello(now);
      }
      return;
    case v1::Envelope::kJobStart:
      return on_job_start(message.job_start(), now);
    case v1::Envelope::kAssign:
      return on_assign(message.assign());
    case v1::Envelope::kCancelTile:
      return on_cancel_tile(message.cancel_tile());
    case v1::Envelope::kCancelJob:
      missed_.erase(message.cancel_job().job());
      return forget_job(message.cancel_job().job());
    case v1::Envelope::kShutdown:
      actions_.push_back(Quit{ExitCode::done, printable(message.shutdown().reason())});
      return;
    case v1::Envelope::kPing:
      if (message.ping().session() != options_.hello.session()) return;
      return forget_results(
          [&message](const Result& result) { return result.number <= message.ping().results(); });
    default:
      return;  // of a newer minor version
  }
}

void WorkerSession::on_bulk(const v1::Envelope& message, Time now) {
  if (message.has_blob_chunk()) on_chunk(message.blob_chunk());
  if (message.has_blob_missing()) on_missing(message.blob_missing());
  for (auto& [id, job] : jobs_) {
    if (message.has_blob_place()) on_place(job, message.blob_place());
    fetch_more(job, now);
  }
}

void WorkerSession::on_missing(const v1::BlobMissing& missing) {
  for (auto it = jobs_.begin(); it != jobs_.end();) {
    const uint64_t id = it->first;
    Job& job = (it++)->second;
    if (!job.fetches()) continue;
    job.fetch.on_missing(missing);
    // A coordinator that has just started had not taken up that job, or the question is an old one:
    // a job that is forgotten is told again.
    if (!job.fetch.failure().empty() && ++missed_[id] < kMostMissed) forget_job(id);
  }
}

void WorkerSession::on_chunk(const v1::BlobChunk& chunk) {
  bool complete = false;
  for (auto& [id, job] : jobs_) complete |= job.fetch.on_chunk(chunk, cache_.blobs());
  if (!complete || !options_.blob_sources.disk) return;
  const Digest digest = *Digest::parse(chunk.digest());
  actions_.push_back(KeepBlob{digest, cache_.blobs().find(digest)});
}

void WorkerSession::on_place(Job& job, const v1::BlobPlace& place) {
  const auto size = job.fetch.on_place(place);
  if (!size) return;
  const BlobPlace there{static_cast<int>(place.process_id()), static_cast<int>(place.file())};
  actions_.push_back(LookForBlob{{*Digest::parse(place.digest()), *size, there}});
}

void WorkerSession::on_found(const BlobFound& found, Time now) {
  for (auto& [id, job] : jobs_) {
    job.fetch.on_loaded(found.digest, found.blob, cache_.blobs());
    fetch_more(job, now);
  }
}

void WorkerSession::on_welcome(const v1::Welcome& welcome, Time now) {
  if (welcome.session() != options_.hello.session()) return;
  const bool another = welcome_.farm() != 0 && welcome.farm() != welcome_.farm();
  if (another) {
    forget_jobs();
    forget_results([](const Result&) { return true; });
  }
  welcome_ = welcome;
  if (welcomed_) return;
  welcomed_ = true;
  hello_pause_ = kFirstHelloPause;
  next_heartbeat_ = now + milliseconds(welcome.heartbeat_ms());
  if (!welcome.bulk_endpoint().empty()) actions_.push_back(ConnectBulk{welcome.bulk_endpoint()});
  for (const Result& result : results_) send() = result.message;
}

bool WorkerSession::make_room(const v1::JobStart& start) {
  uint64_t bytes = scene_bytes(start);
  for (const auto& [id, job] : jobs_) bytes += scene_bytes(job.start);
  for (auto it = jobs_.begin(); it != jobs_.end() && bytes > options_.blob_budget_bytes;) {
    const uint64_t id = (it++)->first;
    const auto run = runs_.lower_bound({id, 0});
    if (run != runs_.end() && run->first.first == id) continue;
    bytes -= scene_bytes(jobs_.at(id).start);
    forget_job(id);
  }
  // One that is alone has room however large it is.
  return bytes <= options_.blob_budget_bytes || jobs_.empty();
}

void WorkerSession::on_job_start(const v1::JobStart& start, Time now) {
  if (!welcomed_ || start.job() == 0) return;
  const auto known = jobs_.find(start.job());
  // The number alone does not make it the same job: a coordinator may have lost count.
  const bool same =
      known != jobs_.end() && known->second.start.SerializeAsString() == start.SerializeAsString();
  if (!same) {
    // Results of one that is not known are of a process before this.
    if (known != jobs_.end()) forget_job(start.job());
    // It is told again until there is room.
    if (!make_room(start)) return;
    Job& fresh = jobs_[start.job()];
    fresh.start = start;
    const auto crashed = options_.crashed_frames.find(start.frame_id());
    if (crashed != options_.crashed_frames.end()) {
      return scene_failed(
          fresh,
          "building the scene ended the worker's process by " + name_of_signal(crashed->second),
          v1::SceneFailed::CRASHED);
    }
    std::vector<const v1::JobStart*> starts;
    for (const auto& [id, job] : jobs_) starts.push_back(&job.start);
    cache_.make_room(starts, options_.blob_budget_bytes);
    std::vector<BlobLookup> lookups;
    auto fetch = cache_.want(start, lookups);
    if (!fetch) {
      return scene_failed(fresh, "the job names its blobs wrongly; expected digests and sizes",
                          v1::SceneFailed::OTHER);
    }
    fresh.fetch = std::move(*fetch);
    fresh.renderer = cache_.built(start);
    for (const BlobLookup& lookup : lookups) actions_.push_back(LookForBlob{lookup});
  }
  drop_builds();
  Job& job = jobs_.at(start.job());
  if (job.bad()) return send_failure(job);
  if (job.renderer) return send_ready(job);
  fetch_more(job, now);
}

void WorkerSession::fetch_more(Job& job, Time now) {
  if (!job.fetches()) return;
  if (!job.fetch.failure().empty()) {
    return scene_failed(job, job.fetch.failure(), v1::SceneFailed::OTHER);
  }
  for (v1::BlobRequest& request : job.fetch.requests(now)) {
    *send(Channel::bulk).mutable_blob_request() = std::move(request);
  }
  if (!job.fetch.finished()) return;
  auto run = cache_.input(job.start);
  if (!run) {
    return scene_failed(job, "the job's scene is not among its blobs", v1::SceneFailed::OTHER);
  }
  run->dropped = job.dropped;
  job.building = true;
  job.run = run;
  actions_.push_back(StartBuild{std::move(run)});
}

void WorkerSession::scene_failed(Job& job, const std::string& text, v1::SceneFailed::Cause cause) {
  job.failure.set_job(job.start.job());
  job.failure.set_frame_id(job.start.frame_id());
  job.failure.set_text(text);
  job.failure.set_cause(cause);
  if (welcomed_) send_failure(job);
}

void WorkerSession::send_failure(Job& job) {
  job.failure.set_session(options_.hello.session());
  *send().mutable_scene_failed() = job.failure;
}

void WorkerSession::send_ready(const Job& job) {
  v1::SceneReady& ready = *send().mutable_scene_ready();
  ready.set_session(options_.hello.session());
  ready.set_job(job.start.job());
  ready.set_frame_id(job.start.frame_id());
  ready.set_build_seconds(job.build_seconds);
  for (const auto& [name, value] : job.renderer->build_counters()) {
    (*ready.mutable_counters()->mutable_values())[name] = value;
  }
  const auto unseen = job.renderer->unseen(job.start.frame().samples_per_pixel());
  if (!unseen) return;
  v1::SceneReady::Unseen& told = *ready.mutable_unseen();
  v1::PixelRect& seen = *told.mutable_seen();
  seen.set_x0(unseen->seen.x0);
  seen.set_y0(unseen->seen.y0);
  seen.set_x1(unseen->seen.x1);
  seen.set_y1(unseen->seen.y1);
  for (const float channel : unseen->one_pixel.values) told.add_value(channel);
  for (const auto& [name, value] : unseen->one_pixel.counters) {
    (*told.mutable_counters()->mutable_values())[name] = value;
  }
}

void WorkerSession::on_built(BuildOutcome outcome, Time) {
  if (outcome.dropped) return;
  std::erase_if(orphaned_builds_, [&](const OrphanedBuild& build) {
    const bool is_it = build.run->job == outcome.job && build.run->frame_id == outcome.frame_id;
    // Its trees are for the job that comes after it.
    if (is_it && outcome.renderer) cache_.keep(build.start, outcome.renderer);
    return is_it;
  });
  const auto it = jobs_.find(outcome.job);
  // Another frame may have the number by now.
  if (it == jobs_.end() || !it->second.building) return;
  if (it->second.start.frame_id() != outcome.frame_id) return;
  Job& job = it->second;
  job.building = false;
  job.run = nullptr;
  if (!outcome.renderer) {
    return scene_failed(job, outcome.failure, outcome.cause);
  }
  job.renderer = std::move(outcome.renderer);
  missed_.erase(outcome.job);
  cache_.keep(job.start, job.renderer);
  job.build_seconds = outcome.seconds;
  send_ready(job);
}

// ------------------------------------------------------------------------------------------ time

void WorkerSession::send_heartbeat(Time now) {
  v1::Heartbeat& heartbeat = *send().mutable_heartbeat();
  heartbeat.set_session(options_.hello.session());
  heartbeat.set_results(results_made_);
  heartbeat.set_leaves(leaves_);
  heartbeat.set_credit(options_.hello.credit());
  for (auto& [id, job] : jobs_) {
    auto& entry = *heartbeat.add_jobs();
    entry.set_job(id);
    entry.set_ready(job.renderer != nullptr);
    entry.set_frame_id(job.start.frame_id());
  }
  for (const auto& [lease, run] : runs_) {
    auto& progress = *heartbeat.add_progress();
    progress.set_job(run->job);
    progress.set_lease(run->lease);
    progress.set_opening(run->opening);
    // Threads that wait for a tree get on with it, as a job does whose scene is being built.
    if (run->started && run->renderer->builds()) ++run->waited;
    progress.set_work_done(run->progress.work_done + run->waited);
    progress.set_started(run->started);
  }
  for (auto& [id, job] : jobs_) {
    if (job.bad()) send_failure(job);
  }
  next_heartbeat_ = now + milliseconds(welcome_.heartbeat_ms());
}

void WorkerSession::on_tick(Time now) {
  silence_.listen(next_deadline(), now);
  next_look_ = now + kLongestPause;
  const Time silence = silence_.length(now);
  if (silence >= options_.orphan_timeout) {
    welcomed_ = false;
    actions_.push_back(Quit{ExitCode::render_failed, "the coordinator is silent"});
    return;
  }
  if (welcomed_ && silence >= milliseconds(welcome_.lost_after_ms())) {
    actions_.push_back(Reconnect{});
    say_hello(now);
  } else if (!welcomed_ && now >= next_hello_) {
    // After a first attempt, perhaps the connection is what is broken.
    if (options_.hello.session() > 1) actions_.push_back(Reconnect{});
    say_hello(now);
  }
  if (welcomed_ && now >= next_heartbeat_) send_heartbeat(now);
  if (now >= next_drop_) drop_builds();
  for (auto& [id, job] : jobs_) fetch_more(job, now);
}

Time WorkerSession::next_deadline() const {
  const Time lost = silence_.reaches(milliseconds(welcome_.lost_after_ms()));
  Time next = welcomed_ ? std::min(next_heartbeat_, lost) : next_hello_;
  next = std::min(next, next_look_);
  next = std::min(next, next_drop_);
  if (options_.orphan_timeout != Time::max()) {
    next = std::min(next, silence_.reaches(options_.orphan_timeout));
  }
  for (const auto& [id, job] : jobs_) {
    const auto fetch = job.fetches() ? job.fetch.next_deadline() : std::nullopt;
    if (fetch) next = std::min(next, *fetch);
  }
  return next;
}

}  // namespace tessera
