#include "coordinator/job_queue.h"

#include <algorithm>
#include <utility>

#include "job/check_job.h"

namespace tessera {

uint64_t JobQueue::enqueue(JobSpec spec, uint64_t submission) {
  check_job(spec);
  constexpr int kJobBits = 20;
  const uint64_t id = (options_.epoch << kJobBits) + ++jobs_queued_;
  queue_.push_back({id, submission, std::move(spec)});
  return id;
}

void JobQueue::interrupt(uint64_t job, Time now) {
  const auto queued =
      std::find_if(queue_.begin(), queue_.end(), [&](const Queued& q) { return q.id == job; });
  if (queued != queue_.end()) {
    ActiveJob unstarted(job, std::move(queued->spec), options_, now);
    queue_.erase(queued);
    unstarted.interrupt();
    results_.emplace(job, unstarted.finish());
  }
  if (active_ && active_->id() == job) active_->interrupt();
}

std::optional<JobResult> JobQueue::take_result(uint64_t job) {
  const auto it = results_.find(job);
  if (it == results_.end()) return std::nullopt;
  std::optional<JobResult> result = std::move(it->second);
  results_.erase(it);
  return result;
}

void JobQueue::end_active(uint64_t workers_seen, uint64_t workers_lost) {
  JobResult result = active_->finish();
  result.report.workers_seen = workers_seen;
  result.report.workers_lost = workers_lost;
  if (submission_ != 0) {
    clients_.ended(submission_, result);
  } else {
    results_.emplace(active_->id(), std::move(result));
  }
  active_.reset();
}

bool JobQueue::start_next(Time now) {
  if (active_ || queue_.empty()) return false;
  Queued next = std::move(queue_.front());
  queue_.pop_front();
  active_ = std::make_unique<ActiveJob>(next.id, std::move(next.spec), options_, now);
  submission_ = next.submission;
  return true;
}

void JobQueue::attend_clients() {
  for (ClientDesk::Ready& ready : clients_.take_ready()) {
    try {
      enqueue(std::move(ready.spec), ready.submission);
    } catch (const Error& error) {
      clients_.refused(ready.submission, error);
    }
  }
  for (const uint64_t submission : clients_.take_abandoned()) {
    std::erase_if(queue_, [&](const Queued& q) { return q.submission == submission; });
    if (active_ && submission_ == submission) active_->interrupt();
  }
}

void JobQueue::tell_client(const JobProgress& progress) {
  if (active_ && submission_ != 0) clients_.running(submission_, progress);
}

JobQueue::FoundBlob JobQueue::find_blob(const Digest& digest) const {
  if (active_) {
    if (BlobData data = active_->find_blob(digest)) return {std::move(data), true};
  }
  return {clients_.find_blob(digest), false};
}

}  // namespace tessera
