#include "client/farm_client.h"

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "base/error.h"
#include "tests/unit/client/answering_transport.h"

namespace tessera {
namespace {

constexpr uint64_t kSubmission = 11;

/// A coordinator that says what a function says to each message, and Ctrl-C after the first one.
class InterruptedTransport : public testing::AnsweringTransport {
 public:
  using Answer = std::function<std::optional<v1::JobStatus>(const v1::Envelope&)>;
  explicit InterruptedTransport(Answer answer) : answer_(std::move(answer)) {}

  std::vector<v1::Envelope> sent;
  std::atomic<bool> stop{false};

 private:
  std::optional<v1::JobStatus> answer(const v1::Envelope& message) override {
    sent.push_back(message);
    stop = true;
    auto status = answer_(message);
    if (status) status->set_submission(kSubmission);
    return status;
  }

  Answer answer_;
};

v1::JobStatus status_of(v1::JobStatus::State state, uint64_t job = 0) {
  v1::JobStatus status;
  status.set_state(state);
  status.set_job(job);
  return status;
}

/// What an interrupted call says.
std::string interrupted_error(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::interrupted);
    return error.what();
  }
  return "no error";
}

std::string interrupted_submission(InterruptedTransport& transport) {
  SubmittedJob job;
  job.request.set_submission(kSubmission);
  FarmClient client(transport, "ipc:///nowhere", transport.stop, std::chrono::milliseconds(100));
  return interrupted_error([&] { client.submit(job); });
}

TEST(InterruptedSubmission, IsCancelledAtTheCoordinator) {
  InterruptedTransport transport([](const v1::Envelope& message) -> std::optional<v1::JobStatus> {
    if (message.has_submit_job()) return status_of(v1::JobStatus::FETCHING);
    if (!message.has_job_query()) return std::nullopt;
    v1::JobStatus status = status_of(v1::JobStatus::ENDED);
    status.set_how(v1::JobEnd::INTERRUPTED);
    return status;
  });
  EXPECT_EQ(interrupted_submission(transport), "interrupted; the job is cancelled");
  ASSERT_EQ(transport.sent.size(), 3u);
  EXPECT_EQ(transport.sent[1].job_query().action(), v1::JobQuery::CANCEL);
  EXPECT_EQ(transport.sent[1].job_query().submission(), kSubmission);
  EXPECT_EQ(transport.sent[2].job_release().submission(), kSubmission);
}

TEST(InterruptedSubmission, TellsThatItMayComeWhereNobodyConfirms) {
  InterruptedTransport transport([](const v1::Envelope&) { return std::nullopt; });
  const std::string said = interrupted_submission(transport);
  EXPECT_NE(said.find("not confirmed"), std::string::npos) << said;
  EXPECT_NE(said.find("it may come"), std::string::npos) << said;
}

TEST(InterruptedSubmission, TellsWhatCannotBeCancelledAnyMore) {
  InterruptedTransport transport([](const v1::Envelope& message) -> std::optional<v1::JobStatus> {
    if (!message.has_job_query()) return std::nullopt;
    return status_of(v1::JobStatus::ENDED, 7);
  });
  EXPECT_EQ(interrupted_submission(transport), "interrupted; job 7 has come and was not cancelled");
}

TEST(InterruptedOrder, TellsThatItMayBeFollowed) {
  InterruptedTransport transport([](const v1::Envelope&) { return std::nullopt; });
  FarmClient client(transport, "ipc:///nowhere", transport.stop);
  v1::JobQuery query;
  EXPECT_EQ(interrupted_error([&] { client.ask(query); }), "interrupted");
  query.set_action(v1::JobQuery::CANCEL);
  EXPECT_EQ(interrupted_error([&] { client.ask(query); }),
            "interrupted; the order may be followed all the same");
}

}  // namespace
}  // namespace tessera
