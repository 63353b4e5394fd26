#include "worker/worker_session.h"

#include <algorithm>
#include <utility>

#include "proto/wire/printable.h"

namespace tessera {
namespace {

constexpr Time kFirstHelloPause = std::chrono::seconds(1);
constexpr Time kLongestHelloPause = std::chrono::seconds(8);
constexpr size_t kMaxUnsent = 1024;
// Assignments beyond what was offered: the coordinator has lost count, and will find out.
constexpr size_t kCreditSlack = 4;

Time milliseconds(uint32_t count) {
  return std::chrono::milliseconds(std::clamp<uint32_t>(count, 10, 3600'000));
}

}  // namespace

WorkerSession::WorkerSession(SessionOptions options, Time now)
    : options_(std::move(options)),
      last_heard_(now),
      next_hello_(now),
      hello_pause_(kFirstHelloPause),
      cache_(options_.blob_sources) {
  options_.hello.set_session(0);
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
  next_hello_ = now + hello_pause_;
  hello_pause_ = std::min(hello_pause_ * 2, kLongestHelloPause);
}

void WorkerSession::leave(const std::string& reason) {
  cancel_all();
  v1::Bye& bye = *send().mutable_bye();
  bye.set_session(options_.hello.session());
  bye.set_reason(reason);
}

void WorkerSession::cancel_all() {
  for (auto& [lease, run] : runs_) run->progress.cancelled = true;
  runs_.clear();
}

void WorkerSession::forget_job() {
  cancel_all();
  unsent_.clear();
  job_ = 0;
  renderer_ = nullptr;
  start_.clear();
  building_ = false;
  build_seconds_ = 0;
  failure_.Clear();
}

// -------------------------------------------------------------------------------------- messages

void WorkerSession::on_message(Channel channel, const v1::Envelope& message, Time now) {
  if (channel == Channel::bulk) {
    if (message.has_blob_chunk()) on_chunk(message.blob_chunk());
    if (message.has_blob_place()) cache_.on_place(message.blob_place());
    if (message.has_blob_missing()) cache_.fetch().on_missing(message.blob_missing());
    return fetch_more(now);
  }
  last_heard_ = now;
  switch (message.message_case()) {
    case v1::Envelope::kWelcome:
      return on_welcome(message.welcome(), now);
    case v1::Envelope::kReject:
      actions_.push_back(Quit{message.reject().reason() == v1::Reject::QUARANTINED
                                  ? ExitCode::render_failed
                                  : ExitCode::bad_usage,
                              "refused by the coordinator: " + printable(message.reject().text())});
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
    case v1::Envelope::kCancelTile: {
      const auto it = runs_.find(message.cancel_tile().lease());
      if (it == runs_.end()) return;
      it->second->progress.cancelled = true;
      // What runs is held until it has really stopped.
      if (!it->second->started) runs_.erase(it);
      return;
    }
    case v1::Envelope::kCancelJob:
      if (message.cancel_job().job() == job_) forget_job();
      return;
    case v1::Envelope::kShutdown:
      actions_.push_back(Quit{ExitCode::done, printable(message.shutdown().reason())});
      return;
    default:
      return;  // a ping, which only shows life, or of a newer minor version
  }
}

void WorkerSession::on_welcome(const v1::Welcome& welcome, Time now) {
  if (welcome.session() != options_.hello.session()) return;
  const bool restarted = welcome_.epoch() != 0 && welcome.epoch() != welcome_.epoch();
  if (restarted) forget_job();
  welcome_ = welcome;
  if (welcomed_) return;
  welcomed_ = true;
  hello_pause_ = kFirstHelloPause;
  next_heartbeat_ = now + milliseconds(welcome.heartbeat_ms());
  if (!welcome.bulk_endpoint().empty()) actions_.push_back(ConnectBulk{welcome.bulk_endpoint()});
  for (v1::Envelope& message : unsent_) send() = std::move(message);
  unsent_.clear();
}

void WorkerSession::on_job_start(const v1::JobStart& start, Time now) {
  if (!welcomed_ || start.job() == 0 || start.job() < job_) return;
  // The number alone does not make it the same job: a coordinator may have lost count.
  if (start.SerializeAsString() != start_) {
    forget_job();
    job_ = start.job();
    start_ = start.SerializeAsString();
    frame_ = start.frame();
    if (!cache_.begin(start, options_.blob_budget_bytes)) {
      return scene_failed("the job names its blobs wrongly; expected digests and sizes",
                          ExitCode::render_failed);
    }
    renderer_ = cache_.built();
  }
  if (scene_bad()) return send_failure();
  if (renderer_) return send_ready();
  fetch_more(now);
}

void WorkerSession::on_chunk(const v1::BlobChunk& chunk) {
  if (!cache_.fetch().on_chunk(chunk, cache_.blobs()) || !options_.blob_sources.disk) return;
  const Digest digest = *Digest::parse(chunk.digest());
  actions_.push_back(KeepBlob{digest, cache_.blobs().find(digest)});
}

void WorkerSession::on_found(const BlobFound& found, Time now) {
  cache_.on_loaded(found);
  fetch_more(now);
}

void WorkerSession::fetch_more(Time now) {
  for (BlobLookup& lookup : cache_.take_lookups()) actions_.push_back(LookForBlob{lookup});
  if (job_ == 0 || renderer_ || building_ || scene_bad()) return;
  BlobFetch& fetch = cache_.fetch();
  if (!fetch.failure().empty()) return scene_failed(fetch.failure(), ExitCode::render_failed);
  for (v1::BlobRequest& request : fetch.requests(now)) {
    *send(Channel::bulk).mutable_blob_request() = std::move(request);
  }
  if (!fetch.finished()) return;
  auto run = cache_.input();
  if (!run) return scene_failed("the scene's bytes are no scene", ExitCode::bad_scene);
  building_ = true;
  actions_.push_back(StartBuild{std::make_shared<const BuildRun>(std::move(*run))});
}

void WorkerSession::scene_failed(const std::string& text, ExitCode code) {
  failure_.set_job(job_);
  failure_.set_text(text);
  failure_.set_exit_code(static_cast<uint32_t>(code));
  if (welcomed_) send_failure();
}

void WorkerSession::send_failure() {
  failure_.set_session(options_.hello.session());
  *send().mutable_scene_failed() = failure_;
}

void WorkerSession::send_ready() {
  v1::SceneReady& ready = *send().mutable_scene_ready();
  ready.set_session(options_.hello.session());
  ready.set_job(job_);
  ready.set_build_seconds(build_seconds_);
  for (const auto& [name, value] : renderer_->build_counters()) {
    (*ready.mutable_counters()->mutable_values())[name] = value;
  }
}

void WorkerSession::on_built(BuildOutcome outcome, Time) {
  if (outcome.job != job_ || !building_) return;
  building_ = false;
  if (!outcome.renderer) {
    return scene_failed(outcome.failure, static_cast<ExitCode>(outcome.exit_code));
  }
  renderer_ = std::move(outcome.renderer);
  cache_.keep(renderer_);
  build_seconds_ = outcome.seconds;
  send_ready();
}

// ----------------------------------------------------------------------------------------- tiles

void WorkerSession::on_assign(const v1::Assign& assign) {
  if (!renderer_ || assign.job() != job_ || runs_.contains(assign.lease()) ||
      runs_.size() >= kCreditSlack * options_.hello.credit()) {
    return;
  }
  const v1::PixelRect& r = assign.rect();
  const PixelRect rect{r.x0(), r.y0(), r.x1(), r.y1()};
  const PixelRect frame{0, 0, static_cast<int>(frame_.width()), static_cast<int>(frame_.height())};
  if (rect.empty() || !frame.contains(rect) || assign.sample_count() == 0) return;
  auto run = std::make_shared<TraceRun>();
  run->job = job_;
  run->lease = assign.lease();
  run->tile = assign.tile();
  run->task = {rect, assign.first_sample(), assign.sample_count()};
  run->renderer = renderer_;
  run->compress = welcome_.compress_pixels();
  runs_.emplace(run->lease, run);
  actions_.push_back(StartTrace{std::move(run)});
}

void WorkerSession::on_traced(TraceOutcome outcome, Time) {
  const TraceRun& run = *outcome.run;
  const auto it = runs_.find(run.lease);
  // One that is not held any more was of a job that is forgotten.
  if (it == runs_.end() || it->second != outcome.run) return;
  runs_.erase(it);
  if (outcome.cancelled) return;
  if (!outcome.failure.empty()) {
    v1::Envelope message;
    v1::TileFailed& failed = *message.mutable_tile_failed();
    failed.set_session(options_.hello.session());
    failed.set_job(run.job);
    failed.set_lease(run.lease);
    failed.set_tile(run.tile);
    failed.set_text(outcome.failure);
    return send_result(std::move(message));
  }
  for (v1::TileBand& band : outcome.bands) {
    band.set_session(options_.hello.session());
    band.set_job(run.job);
    band.set_lease(run.lease);
    band.set_tile(run.tile);
    v1::Envelope message;
    *message.mutable_tile_band() = std::move(band);
    send_result(std::move(message));
  }
}

void WorkerSession::send_result(v1::Envelope message) {
  if (welcomed_) {
    send() = std::move(message);
  } else if (unsent_.size() < kMaxUnsent) {
    unsent_.push_back(std::move(message));
  }
}

// ------------------------------------------------------------------------------------------ time

void WorkerSession::send_heartbeat(Time now) {
  v1::Heartbeat& heartbeat = *send().mutable_heartbeat();
  heartbeat.set_session(options_.hello.session());
  heartbeat.set_job(job_);
  heartbeat.set_ready(renderer_ != nullptr);
  for (const auto& [lease, run] : runs_) {
    auto& progress = *heartbeat.add_progress();
    progress.set_lease(lease);
    progress.set_work_done(run->progress.work_done);
    progress.set_started(run->started);
  }
  if (scene_bad()) send_failure();
  next_heartbeat_ = now + milliseconds(welcome_.heartbeat_ms());
}

void WorkerSession::on_tick(Time now) {
  const Time silence = now - last_heard_;
  if (silence >= options_.orphan_timeout) {
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
  fetch_more(now);
}

Time WorkerSession::next_deadline() const {
  Time next = welcomed_
                  ? std::min(next_heartbeat_, last_heard_ + milliseconds(welcome_.lost_after_ms()))
                  : next_hello_;
  if (options_.orphan_timeout != Time::max()) {
    next = std::min(next, last_heard_ + options_.orphan_timeout);
  }
  const auto fetch = cache_.fetch().next_deadline();
  if (fetch && job_ != 0 && !building_ && !renderer_ && !scene_bad()) next = std::min(next, *fetch);
  return next;
}

}  // namespace tessera
