#include "front/job_orders.h"

#include <gtest/gtest.h>

#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "base/error.h"
#include "job/job_messages.h"
#include "tests/unit/client/answering_transport.h"

namespace tessera {
namespace {

constexpr uint64_t kJob = 7;

/// A coordinator that answers each question with the next of its statuses.
class ScriptedTransport : public testing::AnsweringTransport {
 public:
  std::deque<v1::JobStatus> answers;
  std::vector<v1::JobQuery> asked;
  int unanswered = 0;  ///< questions that it does not hear

 private:
  std::optional<v1::JobStatus> answer(const v1::Envelope& message) override {
    EXPECT_TRUE(message.has_job_query());
    asked.push_back(message.job_query());
    if (unanswered > 0) {
      --unanswered;
      return std::nullopt;
    }
    EXPECT_FALSE(answers.empty());
    if (answers.empty()) return std::nullopt;
    v1::JobStatus status = answers.front();
    answers.pop_front();
    return status;
  }
};

v1::JobStatus job_status(v1::JobStatus::State state, v1::JobEnd::How how = v1::JobEnd::DONE) {
  v1::JobStatus made;
  made.set_job(kJob);
  made.set_state(state);
  made.set_how(how);
  return made;
}

v1::JobQuery job_query(v1::JobQuery::Action action) {
  v1::JobQuery query;
  query.set_job(kJob);
  query.set_action(action);
  return query;
}

class JobOrders : public ::testing::Test {
 protected:
  /// The code and the message of what `work` throws.
  template <typename Work>
  std::pair<ExitCode, std::string> failure(const Work& work) {
    try {
      work();
    } catch (const Error& error) {
      return {error.code(), error.what()};
    }
    return {ExitCode::done, ""};
  }
  auto failure_of(v1::JobQuery::Action action, std::deque<v1::JobStatus> answers) {
    transport_.answers = std::move(answers);
    return failure([&] { give_order(client_, job_query(action)); });
  }

  ScriptedTransport transport_;
  std::atomic<bool> stop_{false};
  FarmClient client_{transport_, "ipc:///nowhere", stop_};
};

using Failure = std::pair<ExitCode, std::string>;
const Failure kNone{ExitCode::done, ""};

TEST_F(JobOrders, OfAJobThatHasEndedAreRefusedButForCancellingItAgain) {
  const auto done = job_status(v1::JobStatus::ENDED);
  const auto cancelled = job_status(v1::JobStatus::ENDED, v1::JobEnd::INTERRUPTED);
  const Failure ended{ExitCode::bad_usage, "JOB: job 7 is done; expected one that has not ended"};
  EXPECT_EQ(failure_of(v1::JobQuery::PAUSE, {done}), ended);
  EXPECT_EQ(failure_of(v1::JobQuery::CANCEL, {done}), ended);
  EXPECT_EQ(failure_of(v1::JobQuery::CANCEL, {cancelled}), kNone);
  EXPECT_EQ(failure_of(v1::JobQuery::RESUME, {cancelled}).first, ExitCode::bad_usage);
  transport_.answers = {done};
  give_order(client_, job_query(v1::JobQuery::CANCEL), true);
}

TEST_F(JobOrders, ToRetryAreForWhatFailedOrIsHeld) {
  const auto running = job_status(v1::JobStatus::RUNNING), held = job_status(v1::JobStatus::HELD);
  const auto failed = job_status(v1::JobStatus::ENDED, v1::JobEnd::FAILED);
  EXPECT_EQ(
      failure_of(v1::JobQuery::RETRY, {running}),
      Failure(ExitCode::bad_usage, "JOB: job 7 is running; expected one that failed or is held"));
  EXPECT_EQ(transport_.asked.back().action(), v1::JobQuery::ASK) << "nothing was ordered";
  EXPECT_EQ(failure_of(v1::JobQuery::RETRY, {held, running}), kNone);
  EXPECT_EQ(transport_.asked.back().action(), v1::JobQuery::RETRY);
  EXPECT_EQ(failure_of(v1::JobQuery::RETRY, {failed, failed}).first, ExitCode::render_failed);
}

TEST_F(JobOrders, WithoutEffectAreToldAndSoIsAJobThatIsNotThere) {
  const auto running = job_status(v1::JobStatus::RUNNING),
             unknown = job_status(v1::JobStatus::UNKNOWN);
  EXPECT_EQ(failure_of(v1::JobQuery::PAUSE, {running}).first, ExitCode::render_failed);
  EXPECT_EQ(failure_of(v1::JobQuery::PAUSE, {unknown}).first, ExitCode::bad_usage);
  transport_.answers = {unknown, running, job_status(v1::JobStatus::ENDED)};
  forget_job(client_, kJob);
  EXPECT_EQ(failure([&] { forget_job(client_, kJob); }),
            Failure(ExitCode::bad_usage,
                    "JOB: job 7 is running; expected one that has ended, or was cancelled"));
  EXPECT_EQ(failure([&] { forget_job(client_, kJob); }).first, ExitCode::render_failed);
}

TEST_F(JobOrders, ToFetchTellWhetherTheFrameHasEndedAndHow) {
  transport_.answers = {job_status(v1::JobStatus::RUNNING)};
  EXPECT_FALSE(fetch_frame(client_, job_query(v1::JobQuery::ASK), false).has_ended());
  JobReport report;
  report.end = JobReport::End::interrupted;
  report.exit_code = ExitCode::interrupted;
  v1::JobStatus ended = job_status(v1::JobStatus::ENDED, v1::JobEnd::INTERRUPTED);
  *ended.mutable_end() = to_message(report);
  transport_.answers = {ended};
  const FetchedFrame fetched = fetch_frame(client_, job_query(v1::JobQuery::ASK), false);
  EXPECT_TRUE(fetched.has_ended());
  EXPECT_FALSE(fetched.picture);
  EXPECT_EQ(fetched.failure.value().code(), ExitCode::interrupted);
  transport_.answers = {job_status(v1::JobStatus::UNKNOWN)};
  EXPECT_EQ(failure([&] { fetch_frame(client_, job_query(v1::JobQuery::ASK), false); }).first,
            ExitCode::render_failed);
}

TEST_F(JobOrders, ToFetchThroughSilenceAreAskedUntilTheyAreAnswered) {
  FarmClient client(transport_, "ipc:///nowhere", stop_, std::chrono::milliseconds(1));
  transport_.unanswered = 3;
  transport_.answers = {job_status(v1::JobStatus::RUNNING)};
  std::vector<std::string> told;
  const FetchedFrame fetched =
      ask_through_silence([&] { return fetch_frame(client, job_query(v1::JobQuery::ASK), false); },
                          [&](const std::string& why) { told.push_back(why); });
  EXPECT_FALSE(fetched.has_ended());
  EXPECT_EQ(transport_.asked.size(), 4u);
  ASSERT_EQ(told.size(), 1u);
  EXPECT_NE(told[0].find("no word from the coordinator"), std::string::npos) << told[0];
  transport_.unanswered = 1;
  EXPECT_EQ(failure([&] { fetch_frame(client, job_query(v1::JobQuery::ASK), false); }).first,
            ExitCode::render_failed);
}

TEST_F(JobOrders, HearNoAnswerToWhatAnotherClientAsked) {
  FarmClient other(transport_, "ipc:///nowhere", stop_);
  transport_.answers = {job_status(v1::JobStatus::PAUSED), job_status(v1::JobStatus::PAUSED)};
  client_.ask(job_query(v1::JobQuery::ASK));
  other.ask(job_query(v1::JobQuery::ASK));
  ASSERT_EQ(transport_.asked.size(), 2u);
  EXPECT_NE(transport_.asked[0].question(), transport_.asked[1].question());
}

}  // namespace
}  // namespace tessera
