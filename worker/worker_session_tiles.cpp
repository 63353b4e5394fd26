// Tiles and their results: the other half of WorkerSession.
#include <algorithm>
#include <utility>

#include "worker/worker_session.h"

namespace tessera {
namespace {

// Assignments beyond what was offered: the coordinator has lost count, and will find out.
constexpr size_t kCreditSlack = 4;

}  // namespace

void WorkerSession::on_assign(const v1::Assign& assign) {
  const auto job = jobs_.find(assign.job());
  if (leaves_ || job == jobs_.end() || !job->second.renderer ||
      runs_.contains({assign.job(), assign.lease()}) ||
      runs_.size() >= kCreditSlack * options_.hello.credit()) {
    return;
  }
  const v1::PixelRect& r = assign.rect();
  const PixelRect rect{r.x0(), r.y0(), r.x1(), r.y1()};
  const v1::FrameSettings& settings = job->second.start.frame();
  const PixelRect frame{0, 0, static_cast<int>(settings.width()),
                        static_cast<int>(settings.height())};
  if (rect.empty() || !frame.contains(rect) || assign.sample_count() == 0) return;
  auto run = std::make_shared<TraceRun>();
  run->job = assign.job();
  run->frame_id = job->second.start.frame_id();
  run->opening = welcome_.opening();
  run->lease = assign.lease();
  run->tile = assign.tile();
  run->task = {rect, assign.first_sample(), assign.sample_count()};
  run->renderer = job->second.renderer;
  run->compress = welcome_.compress_pixels();
  run->job_dropped = job->second.dropped;
  runs_.emplace(LeaseOfJob(run->job, run->lease), run);
  actions_.push_back(StartTrace{std::move(run)});
}

void WorkerSession::on_cancel_tile(const v1::CancelTile& cancel) {
  const auto it = runs_.find({cancel.job(), cancel.lease()});
  if (it == runs_.end()) return;
  if (cancel.unless_started() && it->second->started) return;
  it->second->progress.cancelled = true;
  // What runs is held until it has really stopped.
  if (!it->second->started) runs_.erase(it);
}

void WorkerSession::on_traced(TraceOutcome outcome, Time now) {
  const TraceRun& run = *outcome.run;
  // It has room now for what is wanted, which else the coordinator would learn with the next one.
  // And who leaves waits for no more than to hear that the last one has come.
  if (outcome.cancelled || (leaves_ && runs_.size() <= 1)) {
    next_heartbeat_ = std::min(next_heartbeat_, now);
  }
  const auto it = runs_.find({run.job, run.lease});
  // One that is not held any more was of a job that is forgotten.
  if (it == runs_.end() || it->second != outcome.run) return;
  runs_.erase(it);
  if (outcome.cancelled) return;
  const uint32_t credit = options_.hello.credit();
  if (outcome.out_of_memory && credit > 1) {
    // It goes back, and may come again when there are fewer beside it.
    options_.hello.set_credit(lowered_credit(credit, options_.hello.threads()));
    next_heartbeat_ = std::min(next_heartbeat_, now);
    return;
  }
  if (!outcome.failure.empty()) {
    v1::Envelope message;
    v1::TileFailed& failed = *message.mutable_tile_failed();
    failed.set_session(options_.hello.session());
    failed.set_job(run.job);
    failed.set_frame_id(run.frame_id);
    failed.set_opening(run.opening);
    failed.set_lease(run.lease);
    failed.set_tile(run.tile);
    failed.set_text(outcome.failure);
    return send_result(std::move(message));
  }
  for (v1::TileBand& band : outcome.bands) {
    band.set_session(options_.hello.session());
    band.set_job(run.job);
    band.set_frame_id(run.frame_id);
    band.set_opening(run.opening);
    band.set_lease(run.lease);
    band.set_tile(run.tile);
    v1::Envelope message;
    *message.mutable_tile_band() = std::move(band);
    send_result(std::move(message));
  }
}

void WorkerSession::send_result(v1::Envelope message) {
  if (welcomed_) send() = message;
  result_bytes_ += message.ByteSizeLong();
  results_.push_back({++results_made_, std::move(message)});
  while (result_bytes_ > options_.result_bytes) {
    result_bytes_ -= results_.front().message.ByteSizeLong();
    // Where it was sent, it has most likely come.
    if (!welcomed_) actions_.push_back(SpoolResult{std::move(results_.front().message)});
    results_.pop_front();
  }
}

std::vector<v1::Envelope> WorkerSession::take_unsent() {
  std::vector<v1::Envelope> unsent;
  if (welcomed_) return unsent;
  for (Result& result : std::exchange(results_, {})) unsent.push_back(std::move(result.message));
  result_bytes_ = 0;
  return unsent;
}

void WorkerSession::forget_results(const std::function<bool(const Result&)>& which) {
  std::erase_if(results_, [&](const Result& result) {
    if (!which(result)) return false;
    result_bytes_ -= result.message.ByteSizeLong();
    return true;
  });
}

}  // namespace tessera
