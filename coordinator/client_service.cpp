#include "coordinator/client_service.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <new>
#include <optional>
#include <utility>

#include "base/log.h"
#include "base/plural.h"
#include "base/saturating_sum.h"
#include "coordinator/permissions.h"
#include "job/job_messages.h"
#include "proto/wire/printable.h"

namespace tessera {
namespace {

// More than this at once is refused: each may hold a scene.
constexpr size_t kMaxSubmissions = 64;
/// Of one connection, so that one alone does not keep the others out.
constexpr int64_t kMaxOfPeer = 8;
/// Of statuses of jobs, so that they fit one message.
constexpr size_t kListBytes = size_t{1} << 20;
constexpr char kNoMemory[] = "the coordinator has no memory for this submission";

v1::JobStatus failed_status(uint64_t submission, ExitCode code, const std::string& why) {
  JobReport report;
  report.end = JobReport::End::failed;
  report.exit_code = code;
  report.failure = why;
  v1::JobStatus status;
  status.set_submission(submission);
  status.set_state(v1::JobStatus::ENDED);
  *status.mutable_end() = to_message(report);
  status.set_how(v1::JobEnd::FAILED);
  status.set_exit_code(static_cast<uint32_t>(code));
  status.set_failure(why);
  return status;
}

/// The query in the name of the key by which it came, if there are keys.
v1::JobQuery with_name(v1::JobQuery query, const AllowedKey& sender) {
  if (!sender.key.empty()) query.set_by(sender.name);
  return query;
}

}  // namespace

bool ClientService::on_control(const PeerId& peer, const v1::Envelope& message, Time now,
                               const AllowedKey& sender) {
  switch (message.message_case()) {
    case v1::Envelope::kSubmitJob:
      on_submit(peer, message.submit_job(), now);
      return true;
    case v1::Envelope::kJobQuery:
      on_query(peer, with_name(message.job_query(), sender), may_submit(sender), now);
      return true;
    case v1::Envelope::kJobListQuery:
      on_list_query(peer, message.job_list_query(), now);
      return true;
    case v1::Envelope::kJobRelease:
      on_release(message.job_release());
      return true;
    default:
      return false;
  }
}

// ---------------------------------------------------------------------------------- submissions

int64_t ClientService::count_of(const PeerId& peer) const {
  const auto is_its = [&peer](const auto& entry) { return entry.second.peer == peer; };
  return std::count_if(submissions_.begin(), submissions_.end(), is_its) +
         std::count_if(attached_.begin(), attached_.end(), is_its);
}

void ClientService::on_submit(const PeerId& peer, const v1::SubmitJob& request, Time now) {
  const uint64_t id = request.submission();
  v1::JobQuery query;
  query.set_submission(id);
  if (submissions_.contains(id) || jobs_.find_submission(id))
    return on_query(peer, query, true, now);
  try {
    if (submissions_.size() + attached_.size() >= kMaxSubmissions) {
      throw render_error(
          fmt::format("the coordinator has {} clients; expected fewer", kMaxSubmissions));
    }
    if (count_of(peer) >= kMaxOfPeer) {
      throw render_error(fmt::format("a client with {} submissions; expected fewer", kMaxOfPeer));
    }
    Submission fresh(request, *store_, now);
    fresh.peer = peer;
    const uint64_t others = claimed_bytes(), budget = options_.client_budget_bytes;
    if (saturating_sum(fresh.claimed_bytes(), others) > budget) {
      throw render_error(fmt::format(
          "a submission of {} bytes with its largest picture; expected at most {} beside {} of "
          "others",
          fresh.claimed_bytes(), budget - std::min(budget, others), others));
    }
    Submission& submission = submissions_.emplace(id, std::move(fresh)).first->second;
    // First where the answers to our requests go, then the requests.
    answer(peer, submission.status);
    advance(submission, now);
  } catch (const Error& error) {
    tell_failure(id, error.what(), now);
    answer(peer, failed_status(id, error.code(), error.what()));
  } catch (const std::bad_alloc&) {
    tell_failure(id, kNoMemory, now);
    answer(peer, failed_status(id, ExitCode::render_failed, kNoMemory));
  }
}

void ClientService::on_chunk(const v1::BlobChunk& chunk, Time now) {
  const auto it = submissions_.find(chunk.submission());
  if (it == submissions_.end() || it->second.status.state() != v1::JobStatus::FETCHING) return;
  it->second.on_chunk(chunk);
  advance(it->second, now);
}

void ClientService::on_missing(const v1::BlobMissing& missing, Time now) {
  const auto it = submissions_.find(missing.submission());
  if (it == submissions_.end() || it->second.status.state() != v1::JobStatus::FETCHING) return;
  it->second.on_missing(missing);
  advance(it->second, now);
}

void ClientService::advance(Submission& submission, Time now) {
  const uint64_t id = submission.request().submission();
  try {
    auto requests = submission.advance(*store_, now);
    if (claimed_bytes() > options_.client_budget_bytes) {
      throw render_error(
          fmt::format("submissions of {} bytes with their largest pictures; expected at most {}",
                      claimed_bytes(), options_.client_budget_bytes));
    }
    for (v1::BlobRequest& request : requests) {
      Outgoing& out = outgoing_.emplace_back();
      out.peer = submission.peer;
      *out.message.mutable_blob_request() = std::move(request);
    }
    if (submission.finished()) accept(submission, now);
  } catch (const Error& error) {
    tell_failure(id, error.what(), now);
    submission.fail(failed_status(id, error.code(), error.what()));
  } catch (const std::bad_alloc&) {
    tell_failure(id, kNoMemory, now);
    submission.fail(failed_status(id, ExitCode::render_failed, kNoMemory));
  }
}

void ClientService::tell_failure(uint64_t id, const std::string& why, Time now) {
  const auto count = failures_.note(now);
  if (!count) return;
  spdlog::warn("submission {:016x} failed{}: {}", id,
               *count > 1 ? fmt::format(", and {} before it", *count - 1) : "", printable(why));
}

void ClientService::accept(Submission& submission, Time now) {
  const v1::SubmitJob& request = submission.request();
  const uint64_t id = request.submission();
  jobs_.accept(request, submission.blobs(), submission.scenes());
  const Job& job = *jobs_.find_submission(id);
  const std::string name = request.name().empty() ? "" : " (" + printable(request.name()) + ")";
  spdlog::info("job {}{} has come: {} of {}x{} pixels, {} each, {} bytes of scene", job.id(), name,
               counted(job.frame_count(), "frame"), request.crop().x1() - request.crop().x0(),
               request.crop().y1() - request.crop().y0(),
               counted(request.frames(0).settings().samples_per_pixel(), "sample"),
               submission.scene_bytes());
  if (!request.detached()) attached_[id] = {submission.peer, now};
  answer(submission.peer, jobs_.status(job, 0, now));
  forget(id);
}

void ClientService::forget(uint64_t id) { submissions_.erase(id); }

uint64_t ClientService::claimed_bytes() const {
  uint64_t sum = 0;
  for (const auto& [id, submission] : submissions_) {
    sum = saturating_sum(sum, submission.claimed_bytes());
  }
  return sum;
}

// ------------------------------------------------------------------------------------ questions

void ClientService::on_query(const PeerId& peer, const v1::JobQuery& query, bool is_client,
                             Time now) {
  if (!is_client) return answer(peer, query, now);
  const uint64_t id = query.submission();
  const auto it = submissions_.find(id);
  if (it != submissions_.end()) {
    it->second.peer = peer;
    it->second.last_heard = now;
  } else if (const Job* job = jobs_.find_submission(id); job && !job->request().detached()) {
    attached_[id] = {peer, now};
  }
  answer(peer, query, now);
}

void ClientService::answer(const PeerId& peer, const v1::JobQuery& query, Time now) {
  v1::JobStatus status = ask(query, now);
  status.set_question(query.question());
  answer(peer, std::move(status));
}

v1::JobStatus ClientService::ask(const v1::JobQuery& query, Time now) {
  const uint64_t id = query.submission();
  const auto it = submissions_.find(id);
  if (it != submissions_.end()) return ask(it->second, query);
  Job* const job = id != 0 ? jobs_.find_submission(id) : jobs_.find(query.job());
  if (job) return ask(*job, query, now);
  v1::JobStatus unknown;
  unknown.set_submission(id);
  unknown.set_job(query.job());
  return unknown;
}

v1::JobStatus ClientService::ask(Submission& submission, const v1::JobQuery& query) {
  const bool cancel = query.action() == v1::JobQuery::CANCEL;
  if (cancel && submission.status.state() == v1::JobStatus::FETCHING) {
    JobReport report;
    report.end = JobReport::End::interrupted;
    report.exit_code = ExitCode::interrupted;
    submission.status.set_state(v1::JobStatus::ENDED);
    *submission.status.mutable_end() = to_message(report);
    submission.status.set_how(v1::JobEnd::INTERRUPTED);
    submission.status.set_exit_code(static_cast<uint32_t>(report.exit_code));
  }
  return submission.status;
}

v1::JobStatus ClientService::ask(Job& job, const v1::JobQuery& query, Time now) {
  v1::JobStatus status;
  try {
    act(job, query);
    if (query.action() == v1::JobQuery::FORGET && job.ended()) {
      status.set_job(job.id());
      attached_.erase(job.request().submission());
      jobs_.forget(job);
      return status;
    }
    status = jobs_.status(job, query.frame(), now);
  } catch (const Error& error) {
    status = jobs_.status(job, query.frame(), now);
    status.set_failure(error.what());
  }
  if (query.numbers()) {
    for (const v1::JobFrame& frame : job.request().frames()) status.add_numbers(frame.number());
  }
  return status;
}

void ClientService::act(Job& job, const v1::JobQuery& query) {
  // Orders are repeated until they are answered; each is logged once.
  const v1::KeptJob& kept = job.kept();
  const auto log = [&](const std::string& what) {
    const std::string& name = kept.request().name();
    spdlog::info("job {}{} is {}{}", job.id(), name.empty() ? "" : " (" + printable(name) + ")",
                 what, query.by().empty() ? "" : " by " + printable(query.by()));
  };
  if (query.has_priority() && query.priority() != kept.request().priority()) {
    jobs_.set_priority(job, query.priority());
    log(fmt::format("given priority {}", query.priority()));
  }
  const bool was_paused = kept.paused(), was_cancelled = kept.cancelled();
  switch (query.action()) {
    case v1::JobQuery::CANCEL:
      jobs_.cancel(job);
      if (kept.cancelled() && !was_cancelled) log("cancelled");
      return;
    case v1::JobQuery::PAUSE:
    case v1::JobQuery::RESUME:
      jobs_.pause(job, query.action() == v1::JobQuery::PAUSE, query.by());
      if (kept.paused() != was_paused) log(was_paused ? "resumed" : "paused");
      return;
    case v1::JobQuery::RETRY:
      if (!jobs_.retry(job)) {
        throw usage_error(fmt::format(
            "job {} neither failed nor is held; expected one that did or is", job.id()));
      }
      return log("tried again");
    default:
      return;
  }
}

void ClientService::on_list_query(const PeerId& peer, const v1::JobListQuery& query, Time now) {
  Outgoing& out = outgoing_.emplace_back();
  out.peer = peer;
  v1::JobList& list = *out.message.mutable_job_list();
  list.set_last(jobs_.last_job());
  size_t bytes = 0;
  jobs_.each_status(query.after(), now, [&](v1::JobStatus status) {
    // The number is its client's alone. The frame and its end are told to who asks for that job.
    status.clear_submission();
    status.clear_frame();
    status.clear_end();
    bytes += status.ByteSizeLong();
    list.set_more(bytes > kListBytes);
    if (!list.more()) *list.add_jobs() = std::move(status);
    return !list.more();
  });
}

void ClientService::on_release(const v1::JobRelease& release) {
  const auto it = submissions_.find(release.submission());
  if (it != submissions_.end()) {
    if (it->second.status.state() == v1::JobStatus::ENDED) forget(release.submission());
    return;
  }
  Job* job = release.submission() != 0 ? jobs_.find_submission(release.submission()) : nullptr;
  if (!job || job->request().detached() || !job->ended()) return;
  try {
    jobs_.forget(*job);
    attached_.erase(release.submission());
  } catch (const Error& error) {
    // Its client will not be heard again, and so it is tried again.
    spdlog::warn("{}; it will be tried again", error.what());
  }
}

void ClientService::answer(const PeerId& peer, v1::JobStatus status) {
  Outgoing& out = outgoing_.emplace_back();
  out.peer = peer;
  status.set_bulk_endpoint(options_.bulk_endpoint);
  *out.message.mutable_job_status() = std::move(status);
}

std::vector<ClientService::Outgoing> ClientService::take_outgoing() {
  return std::exchange(outgoing_, {});
}

// ----------------------------------------------------------------------------------------- time

void ClientService::forgive(Time silence, Time now) {
  const auto shift = [&](Time& last_heard) { last_heard = std::min(now, last_heard + silence); };
  for (auto& [id, submission] : submissions_) shift(submission.last_heard);
  for (auto& [id, client] : attached_) shift(client.last_heard);
}

void ClientService::on_tick(Time now) {
  const auto gone = [&](Time last_heard) { return now - last_heard >= options_.client_timeout; };
  std::vector<uint64_t> ids;
  for (const auto& [id, submission] : submissions_) ids.push_back(id);
  for (const uint64_t id : ids) {
    Submission& submission = submissions_.at(id);
    if (gone(submission.last_heard)) {
      spdlog::warn("the client of submission {:016x} is gone", id);
      forget(id);
    } else if (submission.status.state() == v1::JobStatus::FETCHING) {
      advance(submission, now);
    }
  }
  // Those taken up from the store have not been heard of yet.
  for (const auto& [id, job] : jobs_.all()) {
    if (!job->local() && !job->request().detached()) {
      attached_.try_emplace(job->request().submission(), Attached{{}, now});
    }
  }
  for (auto it = attached_.begin(); it != attached_.end();) {
    Job* job = jobs_.find_submission(it->first);
    if (job && !gone(it->second.last_heard)) {
      ++it;
      continue;
    }
    if (job) {
      spdlog::warn("the client of job {} is gone", job->id());
      try {
        jobs_.cancel(*job);
        if (job->running().empty()) jobs_.forget(*job);
      } catch (const Error& error) {
        spdlog::warn("{}; it will be tried again", error.what());
      }
      if (jobs_.find_submission(it->first)) {
        ++it;
        continue;
      }
    }
    it = attached_.erase(it);
  }
}

void ClientService::close(const std::string& why) {
  for (auto& [id, submission] : submissions_) {
    if (submission.status.state() == v1::JobStatus::ENDED) continue;
    submission.status = failed_status(id, ExitCode::render_failed, why);
    answer(submission.peer, submission.status);
  }
  for (const auto& [id, client] : attached_) {
    const Job* job = jobs_.find_submission(id);
    if (!job || job->ended() || client.peer.empty()) continue;
    answer(client.peer, failed_status(id, ExitCode::render_failed, why));
  }
}

}  // namespace tessera
