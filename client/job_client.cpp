#include "client/job_client.h"

#include <algorithm>
#include <cstring>

#include "job/job_messages.h"
#include "proto/wire/printable.h"

namespace tessera {

namespace {

std::string waiting_for(const v1::JobStatus& status) {
  switch (status.state()) {
    case v1::JobStatus::UNKNOWN:
      return JobClient::kForCoordinator;
    case v1::JobStatus::FETCHING:
      return "the scene to be sent";
    default:
      return printable(status.waits_for());
  }
}

}  // namespace
namespace {

constexpr Time kAskEvery = std::chrono::milliseconds(100);
constexpr Time kSubmitEvery = std::chrono::seconds(1);
// So long a cancelled job may take to end over there.
constexpr Time kCancelPatience = std::chrono::seconds(2);

}  // namespace

JobClient::JobClient(const JobSpec& job, uint64_t submission, Time now)
    : crop_(job.crop), aovs_(job.frame.aovs()), silence_(now), next_question_(now) {
  add_frame(job_, job);
  job_.request.set_submission(submission);
  on_tick(now);
}

v1::Envelope& JobClient::send(Channel channel) {
  return outgoing_.emplace_back(channel, v1::Envelope()).second;
}

std::vector<std::pair<Channel, v1::Envelope>> JobClient::take_outgoing() {
  return std::exchange(outgoing_, {});
}

void JobClient::on_tick(Time now) {
  if (result_) return;
  silence_.listen(next_question_, now);
  if (cancelled_ && now >= *cancelled_ + kCancelPatience) return finish_interrupted();
  if (status_.state() == v1::JobStatus::ENDED) {
    fetch_film(now);
    next_question_ = now + kAskEvery;
  } else if (status_.state() == v1::JobStatus::UNKNOWN) {
    *send().mutable_submit_job() = job_.request;
    next_question_ = now + kSubmitEvery;
  } else {
    v1::JobQuery& query = *send().mutable_job_query();
    query.set_submission(job_.request.submission());
    if (cancelled_) query.set_action(v1::JobQuery::CANCEL);
    next_question_ = now + kAskEvery;
  }
}

void JobClient::cancel(Time now) {
  if (cancelled_ || result_) return;
  cancelled_ = now;
  // A coordinator that has not answered may yet have heard of the job.
  if (status_.state() == v1::JobStatus::UNKNOWN) return finish_interrupted();
  next_question_ = now;
}

void JobClient::finish_interrupted() {
  v1::JobQuery& query = *send().mutable_job_query();
  query.set_submission(job_.request.submission());
  query.set_action(v1::JobQuery::CANCEL);
  JobReport report;
  report.end = JobReport::End::interrupted;
  report.exit_code = ExitCode::interrupted;
  finish(std::move(report));
}

void JobClient::on_message(Channel channel, const v1::Envelope& message, Time now) {
  silence_.heard(now);
  if (message.has_job_status()) on_status(message.job_status(), now);
  if (message.has_blob_request()) {
    const auto digest = Digest::parse(message.blob_request().digest());
    send(Channel::bulk) =
        answer_blob_request(message.blob_request(), digest ? job_.blobs.find(*digest) : nullptr);
  }
  if (channel != Channel::bulk || result_) return;
  if (message.has_blob_chunk()) fetch_.on_chunk(message.blob_chunk(), film_);
  if (message.has_blob_missing()) fetch_.on_missing(message.blob_missing());
  // A coordinator that was started anew has not the film, but can make it again.
  if (message.has_blob_missing() && !fetch_.failure().empty() && submits_again_ > 0) {
    --submits_again_;
    fetch_ = BlobFetch();
    status_.Clear();
    return on_tick(now);
  }
  fetch_film(now);
}

void JobClient::on_status(const v1::JobStatus& status, Time now) {
  if (status.submission() != job_.request.submission() || result_ ||
      status_.state() == v1::JobStatus::ENDED) {
    return;
  }
  const bool forgotten = status.state() == v1::JobStatus::UNKNOWN;
  if (forgotten && cancelled_) return finish_interrupted();
  if (forgotten && status_.state() != v1::JobStatus::UNKNOWN) next_question_ = now;
  status_ = status;
  if (!forgotten) next_question_ = std::min(next_question_, now + kAskEvery);
  if (status.state() != v1::JobStatus::ENDED) return;
  const auto digest = Digest::parse(status.end().film_digest());
  const uint64_t expected = film_bytes(crop_, aovs_);
  if (digest && status.end().film_size() == expected) fetch_.want(*digest, expected);
  fetch_film(now);
}

void JobClient::fetch_film(Time now) {
  if (status_.state() != v1::JobStatus::ENDED || result_) return;
  for (v1::BlobRequest& request : fetch_.requests(now)) {
    *send(Channel::bulk).mutable_blob_request() = std::move(request);
  }
  if (fetch_.finished() || !fetch_.failure().empty()) finish(from_message(status_.end()));
}

void JobClient::finish(JobReport report) {
  JobResult result{std::move(report), Film(crop_, aovs_)};
  const auto digest = Digest::parse(status_.end().film_digest());
  const BlobData pixels = digest ? film_.find(*digest) : nullptr;
  if (pixels) {
    std::memcpy(result.film.values().data(), pixels->data(), pixels->size());
  } else {
    result.film.mark_hole(crop_);
    if (result.report.tiles_done > 0 || result.report.holes.empty()) result.report.holes = {crop_};
    result.report.tiles_done = 0;
    if (result.report.end == JobReport::End::done) {
      result.report.end = JobReport::End::failed;
      result.report.exit_code = ExitCode::render_failed;
      result.report.failure = "the picture could not be fetched: " + fetch_.failure();
    }
  }
  send().mutable_job_release()->set_submission(job_.request.submission());
  result_ = std::move(result);
}

JobProgress progress_of(const v1::JobStatus& status) {
  JobProgress progress;
  progress.tiles_done = status.tiles_done();
  progress.tiles_total = status.tiles_total();
  progress.workers = static_cast<int>(status.workers());
  progress.elapsed_seconds = status.elapsed_seconds();
  progress.remaining_seconds = status.remaining_seconds();
  progress.waiting_for = waiting_for(status);
  return progress;
}

std::optional<JobResult> JobClient::take_result() { return std::exchange(result_, std::nullopt); }

}  // namespace tessera
