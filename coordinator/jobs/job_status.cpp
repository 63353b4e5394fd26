#include "coordinator/jobs/job_status.h"

#include <fmt/format.h>

#include <algorithm>

#include "job/job_messages.h"
#include "proto/wire/printable.h"

namespace tessera {
namespace {

/// Of a frame that was never begun.
JobReport interrupted_report() {
  JobReport report;
  report.end = JobReport::End::interrupted;
  report.exit_code = ExitCode::interrupted;
  return report;
}

FarmSnapshot::JobState state_of(const v1::JobStatus& status) {
  switch (status.state()) {
    case v1::JobStatus::ENDED:
      return status.how() == v1::JobEnd::DONE          ? FarmSnapshot::JobState::done
             : status.how() == v1::JobEnd::INTERRUPTED ? FarmSnapshot::JobState::cancelled
                                                       : FarmSnapshot::JobState::failed;
    case v1::JobStatus::PAUSED:
      return FarmSnapshot::JobState::paused;
    case v1::JobStatus::RUNNING:
      return FarmSnapshot::JobState::running;
    case v1::JobStatus::HELD:
      return FarmSnapshot::JobState::held;
    default:
      return FarmSnapshot::JobState::queued;
  }
}

}  // namespace

std::string waits_for(const Job& job, const OpenJob& open, const FarmState& farm) {
  if (job.ended()) return "";
  if (open.paused) {
    const std::string& by = job.kept().paused_by();
    return "somebody to resume it" + (by.empty() ? "" : ": it was paused by " + by);
  }
  if (!farm.trouble.empty()) return "the store: " + farm.trouble;
  if (job.held()) return "what is lacking: " + job.hold_cause();
  if (farm.workers == 0) return "workers";
  if (open.begun.empty()) {
    const Wait wait = wait_of(open, farm.begun, farm.limits);
    if (wait.what == Wait::For::nothing) return "";
    if (wait.what == Wait::For::jobs) {
      return fmt::format("job {}, which was begun before", wait.behind);
    }
    return fmt::format(
        "memory: its picture takes {} bytes, those of jobs that were begun, as job {}, {} of {}",
        open.next->film_bytes, wait.behind, wait.promised_bytes, farm.limits.film_bytes);
  }
  if (tiles_out(open) > 0) return "";
  const OpenJob* urgent = nullptr;
  for (const OpenJob& other : farm.begun) {
    if (tiles_out(other) == 0 || other.priority < open.priority || other.id == open.id) continue;
    if (!urgent || other.priority > urgent->priority) urgent = &other;
  }
  if (!urgent) return "a worker that builds its scene";
  return urgent->priority > open.priority ? fmt::format("job {}, which is more urgent", urgent->id)
                                          : "";
}

v1::JobStatus status_of(const Job& job, const OpenJob& open, const FarmState& farm, uint32_t frame,
                        Time now) {
  const JobProgress progress = job.progress(now, job.works(farm.served));
  const std::string& trouble = farm.trouble;
  const v1::SubmitJob& request = job.request();
  v1::JobStatus status;
  status.set_submission(request.submission());
  status.set_job(job.id());
  status.set_name(request.name());
  status.set_priority(request.priority());
  status.set_weight(std::max<uint32_t>(1, request.weight()));
  status.set_animation(request.animation());
  *status.mutable_crop() = request.crop();
  status.set_state(job.ended()              ? v1::JobStatus::ENDED
                   : job.kept().paused()    ? v1::JobStatus::PAUSED
                   : !job.running().empty() ? v1::JobStatus::RUNNING
                   : job.held()             ? v1::JobStatus::HELD
                                            : v1::JobStatus::QUEUED);
  status.set_tiles_done(progress.tiles_done);
  status.set_tiles_total(progress.tiles_total);
  status.set_tiles_restored(job.tiles_restored());
  status.set_elapsed_seconds(progress.elapsed_seconds);
  status.set_remaining_seconds(progress.remaining_seconds);
  status.set_frames_done(job.frames_done());
  status.set_frames_total(job.frame_count());
  if (frame < job.frame_count()) {
    *status.mutable_frame() = request.frames(static_cast<int>(frame));
    if (const auto& end = job.end_of(frame)) *status.mutable_end() = *end;
  }
  status.set_waits_for(printable(waits_for(job, open, farm)));
  if (status.state() != v1::JobStatus::ENDED) {
    status.set_failure(trouble.empty() ? job.hold_cause() : trouble);
    return status;
  }
  if (job.kept().cancelled()) {
    if (!status.has_end()) *status.mutable_end() = to_message(interrupted_report());
    status.set_how(v1::JobEnd::INTERRUPTED);
    status.set_exit_code(static_cast<uint32_t>(ExitCode::interrupted));
    return status;
  }
  for (uint32_t i = 0; i < job.frame_count(); ++i) {
    const auto& end = job.end_of(i);
    if (!end || end->how() == v1::JobEnd::DONE) continue;
    status.set_how(end->how());
    status.set_exit_code(end->exit_code());
    status.set_failure(end->failure());
    break;
  }
  return status;
}

FarmSnapshot::Job describe(const Job& job, const OpenJob& open, const FarmState& farm, Time now) {
  const v1::JobStatus status = status_of(job, open, farm, 0, now);
  FarmSnapshot::Job shown;
  shown.id = job.id();
  shown.name = printable(status.name());
  shown.state = state_of(status);
  shown.priority = status.priority();
  shown.weight = status.weight();
  shown.frames_done = status.frames_done();
  shown.frames_total = status.frames_total();
  shown.tiles_done = status.tiles_done();
  shown.tiles_total = status.tiles_total();
  shown.tiles_restored = status.tiles_restored();
  shown.width = status.crop().x1() - status.crop().x0();
  shown.height = status.crop().y1() - status.crop().y0();
  shown.elapsed_seconds = status.elapsed_seconds();
  shown.remaining_seconds = status.remaining_seconds();
  shown.worker_seconds = job.traced_seconds();
  shown.exit_code = static_cast<int>(status.exit_code());
  shown.failure = printable(job.ended() ? status.failure() : job.hold_cause());
  shown.waits_for = status.waits_for();
  for (const Job::Running& running : job.running()) shown.frames_running.push_back(running.frame);
  return shown;
}

}  // namespace tessera
