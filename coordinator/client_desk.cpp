#include "coordinator/client_desk.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <limits>
#include <span>
#include <utility>

#include "base/plural.h"
#include "job/job_messages.h"
#include "proto/wire/printable.h"
#include "proto/wire/scene_codec.h"

namespace tessera {
namespace {

// More than this at once is refused: each may hold a scene and a film.
constexpr size_t kMaxSubmissions = 64;

/// What the client sends; for a request whose claim has passed.
uint64_t scene_bytes(const v1::SubmitJob& request) {
  uint64_t sum = request.scene_size();
  for (const uint64_t size : request.blob_sizes()) sum += size;
  return sum;
}

/// The name of a job in the log.
std::string job_name(uint64_t submission) { return fmt::format("job {:016x}", submission); }

/// What it may come to take; the largest number where that is none.
uint64_t claimed_bytes(const v1::SubmitJob& request) {
  constexpr uint64_t kTooMuch = std::numeric_limits<uint64_t>::max();
  uint64_t sum = 0;
  const auto add = [&sum](uint64_t bytes) {
    sum = bytes > kTooMuch - sum ? kTooMuch : sum + bytes;
  };
  add(request.scene_size());
  for (const uint64_t size : request.blob_sizes()) add(size);
  const v1::PixelRect& crop = request.crop();
  const int64_t width = int64_t{crop.x1()} - crop.x0(), height = int64_t{crop.y1()} - crop.y0();
  constexpr int64_t kPixelBytes = kFilmChannels * sizeof(float);
  if (width > 0 && height > 0 && width <= kMaxFrameSide && height <= kMaxFrameSide) {
    add(static_cast<uint64_t>(width * height * kPixelBytes));
  }
  return sum;
}

}  // namespace

bool ClientDesk::on_control(const PeerId& peer, const v1::Envelope& message, Time now) {
  switch (message.message_case()) {
    case v1::Envelope::kSubmitJob:
      on_submit(peer, message.submit_job(), now);
      return true;
    case v1::Envelope::kJobQuery:
      on_query(peer, message.job_query(), now);
      return true;
    case v1::Envelope::kJobRelease:
      on_release(message.job_release());
      return true;
    default:
      return false;
  }
}

void ClientDesk::on_submit(const PeerId& peer, const v1::SubmitJob& request, Time now) {
  const uint64_t id = request.submission();
  const auto known = submissions_.find(id);
  if (known != submissions_.end()) {
    known->second.peer = peer;
    known->second.last_heard = now;
    return answer(known->second);
  }
  Submission fresh;
  fresh.peer = peer;
  fresh.last_heard = now;
  fresh.status.set_submission(id);
  if (id == 0) {
    fail(fresh, ExitCode::bad_usage, "submission 0; expected a number that was drawn");
    return answer(fresh);
  }
  if (submissions_.size() >= kMaxSubmissions) {
    fail(fresh, ExitCode::render_failed,
         fmt::format("the coordinator has {} jobs; expected fewer", kMaxSubmissions));
    return answer(fresh);
  }
  fresh.bytes = claimed_bytes(request);
  if (fresh.bytes > options_.client_budget_bytes - claimed_bytes_) {
    fail(fresh, ExitCode::render_failed,
         fmt::format("a submission of {} bytes with its picture; expected at most {} beside {} of "
                     "others",
                     fresh.bytes, options_.client_budget_bytes - claimed_bytes_, claimed_bytes_));
    return answer(fresh);
  }
  claimed_bytes_ += fresh.bytes;
  fresh.fetch = BlobFetch(id);
  Submission& submission = submissions_.emplace(id, std::move(fresh)).first->second;
  submission.request = request;
  submission.status.set_state(v1::JobStatus::FETCHING);
  const auto scene = Digest::parse(request.scene_digest());
  if (!scene || request.blobs_size() != request.blob_sizes_size()) {
    return fail(submission, ExitCode::bad_usage,
                "a submission without a scene; expected its digest");
  }
  submission.fetch.want(*scene, request.scene_size());
  for (int i = 0; i < request.blobs_size(); ++i) {
    const auto digest = Digest::parse(request.blobs(i));
    if (!digest) return fail(submission, ExitCode::bad_usage, "a blob without a digest");
    submission.fetch.want(*digest, request.blob_sizes(i));
  }
  // First where the answers to our requests go, then the requests.
  answer(submission);
  advance(id, submission, now);
}

void ClientDesk::on_query(const PeerId& peer, const v1::JobQuery& query, Time now) {
  const auto it = submissions_.find(query.submission());
  if (it == submissions_.end()) {
    Submission unknown;
    unknown.peer = peer;
    unknown.status.set_submission(query.submission());
    return answer(unknown);
  }
  it->second.peer = peer;
  it->second.last_heard = now;
  if (query.cancel() && it->second.status.state() != v1::JobStatus::ENDED) {
    // One that runs ends with what there is of it; see ended().
    if (it->second.status.state() != v1::JobStatus::RUNNING) {
      JobReport report;
      report.end = JobReport::End::interrupted;
      report.exit_code = ExitCode::interrupted;
      *it->second.status.mutable_end() = to_message(report);
      it->second.status.set_state(v1::JobStatus::ENDED);
    }
    abandoned_.push_back(query.submission());
  }
  answer(it->second);
}

void ClientDesk::on_release(const v1::JobRelease& release) {
  const auto it = submissions_.find(release.submission());
  if (it != submissions_.end() && it->second.status.state() == v1::JobStatus::ENDED) forget(it);
}

ClientDesk::Submissions::iterator ClientDesk::forget(Submissions::iterator it) {
  claimed_bytes_ -= it->second.bytes;
  return submissions_.erase(it);
}

ClientDesk::Submission* ClientDesk::fetching(uint64_t id) {
  const auto it = submissions_.find(id);
  const bool is = it != submissions_.end() && it->second.status.state() == v1::JobStatus::FETCHING;
  return is ? &it->second : nullptr;
}

void ClientDesk::on_chunk(const v1::BlobChunk& chunk, Time now) {
  Submission* submission = fetching(chunk.submission());
  if (!submission) return;
  submission->fetch.on_chunk(chunk, submission->blobs);
  advance(chunk.submission(), *submission, now);
}

void ClientDesk::on_missing(const v1::BlobMissing& missing) {
  Submission* submission = fetching(missing.submission());
  if (!submission) return;
  submission->fetch.on_missing(missing);
  if (submission->fetch.failure().empty()) return;
  fail(*submission, ExitCode::render_failed, submission->fetch.failure());
}

void ClientDesk::on_tick(Time now) {
  for (auto it = submissions_.begin(); it != submissions_.end();) {
    Submission& submission = it->second;
    if (submission.status.state() == v1::JobStatus::FETCHING) advance(it->first, submission, now);
    if (now - submission.last_heard < options_.client_timeout) {
      ++it;
      continue;
    }
    if (submission.status.state() == v1::JobStatus::ENDED) {
      spdlog::warn("nobody has fetched the picture of {}", job_name(it->first));
    } else {
      spdlog::warn("the client of {} is gone", job_name(it->first));
    }
    abandoned_.push_back(it->first);
    it = forget(it);
  }
}

void ClientDesk::advance(uint64_t id, Submission& submission, Time now) {
  if (!submission.fetch.failure().empty()) {
    return fail(submission, ExitCode::render_failed, submission.fetch.failure());
  }
  for (v1::BlobRequest& request : submission.fetch.requests(now)) {
    Outgoing& out = outgoing_.emplace_back();
    out.peer = submission.peer;
    *out.message.mutable_blob_request() = std::move(request);
  }
  if (!submission.fetch.finished()) return;
  auto spec = read_spec(submission);
  if (!spec) return;
  submission.status.set_state(v1::JobStatus::QUEUED);
  spdlog::info("{} has come: {}x{} pixels, {} each, {} bytes of scene", job_name(id),
               spec->crop.width(), spec->crop.height(),
               counted(spec->frame.samples_per_pixel(), "sample"), scene_bytes(submission.request));
  ready_.push_back({id, std::move(*spec)});
}

std::optional<JobSpec> ClientDesk::read_spec(Submission& submission) {
  const v1::SubmitJob& request = submission.request;
  const BlobData bytes = submission.blobs.find(*Digest::parse(request.scene_digest()));
  auto scene = bytes ? parse_scene({reinterpret_cast<const char*>(bytes->data()), bytes->size()})
                     : std::nullopt;
  if (!scene) {
    fail(submission, ExitCode::bad_scene, "the submitted bytes are no scene");
    return std::nullopt;
  }
  JobSpec spec;
  spec.scene = std::move(*scene);
  // The job adds the scene itself to its blobs again; only what it refers to is listed.
  for (const std::string& hex : request.blobs()) {
    const Digest digest = *Digest::parse(hex);
    spec.blobs.put(digest, submission.blobs.find(digest));
  }
  submission.blobs = {};
  spec.frame = request.frame();
  const v1::PixelRect& crop = request.crop();
  spec.crop = {crop.x0(), crop.y0(), crop.x1(), crop.y1()};
  spec.tile_size = static_cast<int>(std::min<uint32_t>(request.tile_size(), kMaxFrameSide));
  return spec;
}

void ClientDesk::answer(const Submission& submission) {
  Outgoing& out = outgoing_.emplace_back();
  out.peer = submission.peer;
  *out.message.mutable_job_status() = submission.status;
  out.message.mutable_job_status()->set_bulk_endpoint(options_.bulk_endpoint);
}

void ClientDesk::fail(Submission& submission, ExitCode code, const std::string& why) {
  JobReport report;
  report.end = JobReport::End::failed;
  report.exit_code = code;
  report.failure = why;
  *submission.status.mutable_end() = to_message(report);
  submission.status.set_state(v1::JobStatus::ENDED);
  spdlog::warn("{} failed: {}", job_name(submission.status.submission()), printable(why));
}

std::vector<ClientDesk::Ready> ClientDesk::take_ready() { return std::exchange(ready_, {}); }

std::vector<ClientDesk::Outgoing> ClientDesk::take_outgoing() {
  return std::exchange(outgoing_, {});
}

std::vector<uint64_t> ClientDesk::take_abandoned() { return std::exchange(abandoned_, {}); }

void ClientDesk::refused(uint64_t id, const Error& error) {
  const auto it = submissions_.find(id);
  if (it != submissions_.end()) fail(it->second, error.code(), error.what());
}

void ClientDesk::running(uint64_t id, const JobProgress& progress) {
  const auto it = submissions_.find(id);
  if (it == submissions_.end() || it->second.status.state() == v1::JobStatus::ENDED) return;
  v1::JobStatus& status = it->second.status;
  status.set_state(v1::JobStatus::RUNNING);
  status.set_tiles_done(progress.tiles_done);
  status.set_tiles_total(progress.tiles_total);
  status.set_workers(static_cast<uint32_t>(progress.workers));
  status.set_elapsed_seconds(progress.elapsed_seconds);
  status.set_remaining_seconds(progress.remaining_seconds);
}

void ClientDesk::ended(uint64_t id, const JobResult& result) {
  const auto it = submissions_.find(id);
  if (it == submissions_.end()) return;
  Submission& submission = it->second;
  const auto pixels = std::as_bytes(result.film.values());
  submission.film = std::make_shared<const std::vector<std::byte>>(pixels.begin(), pixels.end());
  submission.film_digest = Digest::of(pixels);
  *submission.status.mutable_end() = to_message(result.report);
  submission.status.mutable_end()->set_film_digest(submission.film_digest.hex());
  submission.status.mutable_end()->set_film_size(pixels.size());
  submission.status.set_state(v1::JobStatus::ENDED);
  log_end(id, result.report);
}

void ClientDesk::close(const std::string& why) {
  for (auto& [id, submission] : submissions_) {
    if (submission.status.state() == v1::JobStatus::ENDED) continue;
    fail(submission, ExitCode::render_failed, why);
    answer(submission);
  }
}

void ClientDesk::log_end(uint64_t id, const JobReport& report) const {
  switch (report.end) {
    case JobReport::End::done:
      return spdlog::info("{} is done, traced in {:.2f} s", job_name(id), report.trace_seconds);
    case JobReport::End::failed:
      return spdlog::warn("{} failed: {}", job_name(id), printable(report.failure));
    case JobReport::End::interrupted:
      return spdlog::info("{} was cancelled, or its client is gone", job_name(id));
  }
}

BlobData ClientDesk::find_blob(const Digest& digest) const {
  for (const auto& [id, submission] : submissions_) {
    if (submission.film && submission.film_digest == digest) return submission.film;
  }
  return nullptr;
}

}  // namespace tessera
