#include "client/job_client.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

/// What the client makes of that end of its job.
JobResult end_of_job(const v1::JobEnd& end) {
  JobSpec spec;
  spec.crop = {0, 0, 8, 8};
  JobClient client(spec, 7, {});
  v1::Envelope message;
  v1::JobStatus& status = *message.mutable_job_status();
  status.set_submission(7);
  status.set_state(v1::JobStatus::ENDED);
  *status.mutable_end() = end;
  client.on_message(Channel::control, message, {});
  auto result = client.take_result();
  EXPECT_TRUE(result);
  return result ? std::move(*result) : JobResult{{}, Film(spec.crop)};
}

TEST(JobProgress, SaysWhatIsWaitedFor) {
  const auto waiting_for = [](v1::JobStatus::State state, const std::string& told) {
    v1::JobStatus status;
    status.set_state(state);
    status.set_waits_for(told);
    return progress_of(status).waiting_for;
  };
  EXPECT_EQ(waiting_for(v1::JobStatus::FETCHING, ""), "the scene to be sent");
  EXPECT_EQ(waiting_for(v1::JobStatus::QUEUED, "workers"), "workers");
  EXPECT_EQ(waiting_for(v1::JobStatus::RUNNING, ""), "");
  EXPECT_EQ(waiting_for(v1::JobStatus::PAUSED, "\x1b[31m"), "\\x1b[31m");
}

TEST(JobClient, ARefusedJobHasNoTiles) {
  v1::JobEnd end;
  end.set_how(v1::JobEnd::FAILED);
  end.set_exit_code(static_cast<uint32_t>(ExitCode::bad_usage));
  end.set_failure("no");
  const JobResult result = end_of_job(end);
  EXPECT_EQ(result.report.exit_code, ExitCode::bad_usage);
  EXPECT_EQ(result.report.failure, "no");
  EXPECT_EQ(result.report.tiles_done, 0u);
}

TEST(JobClient, WhatCannotBeFetchedIsNotDone) {
  v1::JobEnd end;
  end.set_how(v1::JobEnd::DONE);
  (*end.mutable_totals()->mutable_values())["tiles_done"] = 4;
  const JobResult result = end_of_job(end);
  EXPECT_EQ(result.report.end, JobReport::End::failed);
  EXPECT_EQ(result.report.exit_code, ExitCode::render_failed);
  EXPECT_EQ(result.report.tiles_done, 0u);
}

TEST(JobClient, WhatTheOtherSideSaysIsPrintable) {
  v1::JobEnd end;
  end.set_how(v1::JobEnd::FAILED);
  end.set_failure(
      "a\x1b[31m\nb\x7f\xc2\x9b"
      "c\xc3\xa9");
  EXPECT_EQ(end_of_job(end).report.failure, R"(a\x1b[31m\nb\x7f\x9bc)"
                                            "\xc3\xa9");
  end.set_failure(std::string(999, 'a') + "\xc3\xa9");
  EXPECT_EQ(end_of_job(end).report.failure, std::string(999, 'a'));
}

TEST(JobClient, TimeInWhichItDidNotRunIsNoSilenceOfTheCoordinator) {
  JobSpec spec;
  spec.crop = {0, 0, 8, 8};
  JobClient client(spec, 7, {});
  const Time begin = client.next_deadline();
  client.on_tick(begin + std::chrono::hours(1));
  EXPECT_EQ(client.silence(begin + std::chrono::hours(1)), Time{0}) << "it has just asked again";
  Time now = client.next_deadline();
  for (; now < begin + std::chrono::hours(1) + std::chrono::seconds(20);
       now = client.next_deadline())
    client.on_tick(now);
  EXPECT_GT(client.silence(now), std::chrono::seconds(19));
}

TEST(JobClient, OnlyWhatIsDoneHasExitCodeZero) {
  const auto exit_code = [](v1::JobEnd::How how, uint32_t code) {
    v1::JobEnd end;
    end.set_how(how);
    end.set_exit_code(code);
    return end_of_job(end).report.exit_code;
  };
  EXPECT_EQ(exit_code(v1::JobEnd::FAILED, 0), ExitCode::render_failed);
  EXPECT_EQ(exit_code(v1::JobEnd::FAILED, 99), ExitCode::render_failed);
  EXPECT_EQ(exit_code(v1::JobEnd::FAILED, 1), ExitCode::bad_scene);
  EXPECT_EQ(exit_code(v1::JobEnd::INTERRUPTED, 0), ExitCode::interrupted);
  EXPECT_EQ(exit_code(v1::JobEnd::DONE, 2), ExitCode::bad_usage);
}

}  // namespace
}  // namespace tessera
