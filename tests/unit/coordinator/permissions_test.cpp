#include "coordinator/permissions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera {
namespace {

/// Every kind of message, by its field.
std::vector<v1::Envelope> all_messages() {
  std::vector<v1::Envelope> all;
  const auto* descriptor = v1::Envelope::descriptor();
  for (int i = 0; i < descriptor->field_count(); ++i) {
    all.emplace_back();
    all.back().GetReflection()->MutableMessage(&all.back(), descriptor->field(i));
  }
  all.emplace_back().mutable_job_query()->set_action(v1::JobQuery::CANCEL);
  all.emplace_back().mutable_job_query()->set_priority(0);
  all.emplace_back();
  return all;
}

std::set<std::string> allowed_to(Role role) {
  std::set<std::string> names;
  for (const v1::Envelope& message : all_messages()) {
    if (refuse({role, "x"}, message)) continue;
    const auto* field =
        v1::Envelope::descriptor()->FindFieldByNumber(static_cast<int>(message.message_case()));
    const v1::JobQuery& query = message.job_query();
    names.insert(field ? field->name() + (query.action() != 0    ? " cancel"
                                          : query.has_priority() ? " priority"
                                                                 : "")
                       : "nothing");
  }
  return names;
}

TEST(Permissions, EachRoleSaysWhatItIsThereFor) {
  using ::testing::UnorderedElementsAre;
  EXPECT_THAT(allowed_to(Role::worker),
              UnorderedElementsAre("hello", "heartbeat", "tile_band", "tile_failed", "bye",
                                   "scene_ready", "scene_failed", "blob_request"));
  EXPECT_THAT(
      allowed_to(Role::submitter),
      UnorderedElementsAre("submit_job", "job_query", "job_query cancel", "job_query priority",
                           "job_list_query", "job_release", "blob_request", "blob_chunk",
                           "blob_missing", "done_tiles_query"));
  EXPECT_THAT(allowed_to(Role::viewer), UnorderedElementsAre("job_query", "job_list_query"));
  EXPECT_THAT(allowed_to(Role::enrol), UnorderedElementsAre("enrol"));
  EXPECT_THAT(allowed_to(Role::revoked), UnorderedElementsAre());
}

TEST(Permissions, WithoutKeysNothingIsRefused) {
  for (const v1::Envelope& message : all_messages()) {
    EXPECT_FALSE(refuse({Role::any, ""}, message)) << message.ShortDebugString();
  }
}

TEST(Permissions, ARefusalNamesBothRoles) {
  v1::Envelope message;
  message.mutable_submit_job();
  const auto reject = refuse({Role::worker, "node-7"}, message);
  ASSERT_TRUE(reject);
  EXPECT_EQ(reject->reason(), v1::Reject::NOT_ALLOWED);
  EXPECT_EQ(reject->text(), "the key of node-7 is a worker's; expected a submitter's");
  message.mutable_job_list_query();
  EXPECT_EQ(refuse({Role::worker, "node-7"}, message)->text(),
            "the key of node-7 is a worker's; expected a viewer's or submitter's");
  EXPECT_EQ(refuse({Role::enrol, "rack-1"}, message)->text(),
            "the key of rack-1 is an enrolment token; expected a viewer's or submitter's");
  message.mutable_enrol();
  EXPECT_EQ(refuse({Role::worker, "node-7"}, message)->text(),
            "the key of node-7 is a worker's; expected an enrolment token");
}

}  // namespace
}  // namespace tessera
