#include "coordinator/worker_registry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

v1::Hello hello(WorkerId id, uint64_t session = 1) {
  v1::Hello hello;
  hello.set_protocol_major(kProtocolMajor);
  hello.set_protocol_minor(kProtocolMinor + 7);
  hello.set_numerics_id(kNumericsId);
  hello.set_worker_id(id);
  hello.set_session(session);
  hello.set_host("here");
  hello.set_process_id(static_cast<uint32_t>(id) + 1000);
  hello.set_credit(2);
  return hello;
}

CoordinatorOptions options() {
  CoordinatorOptions result;
  result.host = "here";
  return result;
}

TEST(WorkerRegistry, TakesANewerMinorVersionAndNoOtherMajorOne) {
  const WorkerRegistry registry(options());
  EXPECT_FALSE(registry.judge(hello(1)));
  v1::Hello other = hello(1);
  other.set_protocol_major(kProtocolMajor + 1);
  const auto reject = registry.judge(other);
  ASSERT_TRUE(reject);
  EXPECT_EQ(reject->reason(), v1::Reject::PROTOCOL);
  EXPECT_THAT(reject->text(), HasSubstr(std::to_string(kProtocolMajor + 1) + "."));
  EXPECT_THAT(reject->text(), HasSubstr("expected " + std::to_string(kProtocolMajor)));
}

TEST(WorkerRegistry, RefusesOtherNumericsAndNonsense) {
  const WorkerRegistry registry(options());
  v1::Hello other = hello(1);
  other.set_numerics_id("x87");
  EXPECT_EQ(registry.judge(other)->reason(), v1::Reject::NUMERICS);
  EXPECT_THAT(registry.judge(other)->text(), HasSubstr("'x87'"));
  EXPECT_THAT(registry.judge(other)->text(), HasSubstr(kNumericsId));
  EXPECT_TRUE(registry.judge(hello(0)));
  EXPECT_TRUE(registry.judge(hello(1, 0)));
  for (const uint32_t credit : {0u, 0xffffffffu}) {
    other = hello(1);
    other.set_credit(credit);
    EXPECT_TRUE(registry.judge(other));
  }
}

TEST(WorkerRegistry, KnowsAWorkerByItsIdThroughReconnections) {
  WorkerRegistry registry(options());
  const auto first = registry.greet("p1", hello(5), {});
  EXPECT_TRUE(first.anew);
  EXPECT_FALSE(registry.greet("p1", hello(5), {}).anew) << "a doubled hello";
  const auto again = registry.greet("p2", hello(5, 2), {});
  EXPECT_TRUE(again.anew);
  EXPECT_EQ(again.worker, first.worker);
  EXPECT_EQ(registry.by_peer("p1"), nullptr);
  EXPECT_EQ(registry.by_peer("p2"), again.worker);
  EXPECT_EQ(registry.greet("p1", hello(5, 1), {}).worker, nullptr) << "a late hello";
  EXPECT_TRUE(registry.greet("p1", hello(5, 1), {}).older);
  EXPECT_EQ(registry.by_peer("p2"), again.worker);
  EXPECT_EQ(registry.present_count(), 1);
}

TEST(WorkerRegistry, SuspectsInUnderThreeSecondsAndLosesAfterFive) {
  WorkerRegistry registry(options());
  WorkerRecord* quiet = registry.greet("p1", hello(1), {}).worker;
  WorkerRecord* lively = registry.greet("p2", hello(2), {}).worker;
  for (int second = 1; second < 3; ++second) {
    EXPECT_THAT(registry.check(seconds(second)).suspects, IsEmpty());
  }
  registry.heard(*lively, seconds(2));
  EXPECT_THAT(registry.check(milliseconds(2900)).suspects, ElementsAre(quiet));
  EXPECT_THAT(registry.check(seconds(4)).suspects, IsEmpty()) << "told once";
  registry.heard(*lively, seconds(4));
  EXPECT_THAT(registry.check(seconds(5)).lost, ElementsAre(quiet));
  registry.lose(*quiet);
  EXPECT_THAT(registry.present(), ElementsAre(lively));
  EXPECT_THAT(registry.check(seconds(6)).lost, IsEmpty());
  EXPECT_TRUE(registry.heard(*quiet, seconds(6))) << "back";
  EXPECT_EQ(registry.present_count(), 2);
}

TEST(WorkerRegistry, ForgetsTheLostInTheEnd) {
  WorkerRegistry registry(options());
  registry.lose(*registry.greet("p1", hello(1), {}).worker);
  registry.check(seconds(599));
  EXPECT_NE(registry.by_id(1), nullptr);
  registry.check(seconds(600));
  EXPECT_EQ(registry.by_id(1), nullptr);
  EXPECT_EQ(registry.by_peer("p1"), nullptr);
}

TEST(WorkerRegistry, FindsProcessesOfThisHostOnly) {
  WorkerRegistry registry(options());
  WorkerRecord* here = registry.greet("p1", hello(1), {}).worker;
  v1::Hello far = hello(2);
  far.set_host("there");
  registry.greet("p2", far, {});
  EXPECT_EQ(registry.by_process(1001), here);
  EXPECT_EQ(registry.by_process(1002), nullptr);
}

TEST(WorkerRegistry, RefusesWhomItSetAside) {
  WorkerRegistry registry(options());
  WorkerRecord* worker = registry.greet("p1", hello(1), {}).worker;
  worker->failures = 3;
  registry.set_aside(1, "worker here:1001 failed 3 tiles");
  EXPECT_EQ(registry.judge(hello(1, 2))->reason(), v1::Reject::QUARANTINED);
  EXPECT_THAT(registry.judge(hello(1, 2))->text(), HasSubstr("here:1001 failed 3 tiles"));
}

TEST(WorkerRegistry, AnIdIsOfTheKeyThatSaidItFirst) {
  WorkerRegistry registry(options());
  const AllowedKey alice{Role::worker, "alice", "aa"}, mallory{Role::worker, "mallory", "bb"};
  WorkerRecord* worker = registry.greet("p1", hello(5), {}, alice).worker;
  const auto reject = registry.judge(hello(5, ~uint64_t{0}), mallory);
  ASSERT_TRUE(reject);
  EXPECT_EQ(reject->reason(), v1::Reject::ID_TAKEN);
  EXPECT_EQ(reject->session(), ~uint64_t{0});
  EXPECT_THAT(reject->text(), HasSubstr("another worker uses this id"));
  EXPECT_FALSE(registry.judge(hello(5, 2), alice)) << "its own later session";
  registry.lose(*worker);
  EXPECT_TRUE(registry.judge(hello(5, 3), mallory)) << "also while it is lost";
  EXPECT_TRUE(registry.judge(hello(5, 3))) << "or by no key";
}

TEST(WorkerRegistry, CountsFailuresAgainstTheKey) {
  WorkerRegistry registry(options());
  const AllowedKey mallory{Role::worker, "mallory", "bb"};
  WorkerRecord* one = registry.greet("p1", hello(1), {}, mallory).worker;
  WorkerRecord* two = registry.greet("p2", hello(2), {}, mallory).worker;
  EXPECT_EQ(registry.blame(*one), 1);
  EXPECT_EQ(registry.blame(*two), 2) << "another id, the same key";
  WorkerRecord* keyless = registry.greet("p3", hello(3), {}).worker;
  EXPECT_EQ(registry.blame(*keyless), 1);
  EXPECT_THAT(registry.with_key("bb"), ElementsAre(one, two));
  registry.set_key_aside("bb", "enough");
  EXPECT_EQ(registry.judge(hello(9), mallory)->reason(), v1::Reject::QUARANTINED);
  EXPECT_FALSE(registry.judge(hello(9), {Role::worker, "alice", "aa"}));
  registry.forgive_keys();
  EXPECT_FALSE(registry.judge(hello(9), mallory));
}

}  // namespace
}  // namespace tessera
