// Machines that make their keys known by enrolment tokens, and those that lie.
#include "coordinator/key_registry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/error.h"
#include "tests/error_of.h"

namespace tessera {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

constexpr WallTime kNow = std::chrono::sys_days(std::chrono::year(2026) / 11 / 24) + 12h;

/// A registry with two tokens for workers and one for viewers, and its file.
class KeyRegistryTest : public ::testing::Test {
 protected:
  static std::string new_key() { return key_text(make_key_pair().public_key); }
  static v1::Enrol request(const std::string& key, const std::string& name) {
    v1::Enrol enrol;
    enrol.set_public_key(key);
    enrol.set_name(name);
    return enrol;
  }
  AllowList listed(const std::string& more = {}) const {
    return AllowList::parse(first_ + " enrol:worker rack-1\n" + second_ + " enrol:worker rack-2\n" +
                                wall_ + " enrol:viewer walls\n" + alice_ + " submitter alice\n" +
                                more,
                            "farm.allow");
  }
  /// As after a start of the coordinator: with what is in the file.
  KeyRegistry opened(const std::string& more = {}) {
    return KeyRegistry(
        listed(more),
        [this](const std::string& text) {
          if (full_) throw render_error("no space left on device");
          ++writes_;
          file_ = text;
        },
        file_, "enrolled.allow");
  }
  v1::EnrolAnswer enrol(const std::string& token, const v1::Enrol& request) {
    return registry_.enrol(*registry_.keys().find(token), request, kNow);
  }

  std::string first_ = new_key(), second_ = new_key(), wall_ = new_key(), alice_ = new_key();
  std::string file_;
  int writes_ = 0;
  bool full_ = false;
  KeyRegistry registry_ = opened();
};

TEST_F(KeyRegistryTest, AKeyIsKeptAndLetInByTheRoleOfItsToken) {
  const std::string node = new_key(), wall = new_key();
  const v1::EnrolAnswer answer = enrol(first_, request(node, "node-7"));
  EXPECT_EQ(answer.outcome(), v1::EnrolAnswer::ENROLLED);
  EXPECT_EQ(answer.role(), "worker");
  EXPECT_EQ(answer.name(), "node-7");
  EXPECT_EQ(enrol(wall_, request(wall, "wall")).role(), "viewer");
  EXPECT_EQ(file_, node + " worker node-7 token=" + first_ + " since=2026-11-24T12:00:00Z\n" +
                       wall + " viewer wall token=" + wall_ + " since=2026-11-24T12:00:00Z\n");
  ASSERT_TRUE(registry_.keys().admitted(node));
  EXPECT_EQ(registry_.keys().admitted(node)->role, Role::worker);
  EXPECT_EQ(registry_.keys().admitted(wall)->role, Role::viewer);
  EXPECT_EQ(registry_.keys().admitted(alice_)->role, Role::submitter);
}

TEST_F(KeyRegistryTest, ATokenIsOfUseOnceAlsoAfterARestart) {
  const std::string node = new_key();
  enrol(first_, request(node, "node-7"));
  for (int i = 0; i < 2; ++i) {
    const v1::EnrolAnswer answer = enrol(first_, request(new_key(), "node-8"));
    EXPECT_EQ(answer.outcome(), v1::EnrolAnswer::TOKEN_USED);
    EXPECT_THAT(answer.text(), HasSubstr("node-7"));
    registry_ = opened();
  }
  EXPECT_TRUE(registry_.keys().admitted(node));
  EXPECT_EQ(registry_.keys().size(), 5u);
  EXPECT_EQ(writes_, 1);
}

TEST_F(KeyRegistryTest, AskingAgainForTheSameKeySucceedsThoughTheAnswerWasLost) {
  const std::string node = new_key();
  enrol(first_, request(node, "node-7"));
  registry_ = opened();  // killed after it was kept and before it was answered
  for (const std::string& token : {first_, second_}) {
    const v1::EnrolAnswer answer = enrol(token, request(node, "node-7"));
    EXPECT_EQ(answer.outcome(), v1::EnrolAnswer::ENROLLED);
    EXPECT_EQ(answer.role(), "worker");
  }
  EXPECT_EQ(writes_, 1);
  // The second token was not needed for that.
  EXPECT_EQ(enrol(second_, request(new_key(), "node-8")).outcome(), v1::EnrolAnswer::ENROLLED);
  EXPECT_EQ(enrol(wall_, request(node, "node-7")).outcome(), v1::EnrolAnswer::REFUSED);
}

TEST_F(KeyRegistryTest, WhatCannotBeKeptIsNotLetInAndMayBeAskedAgain) {
  const std::string node = new_key();
  full_ = true;
  const v1::EnrolAnswer answer = enrol(first_, request(node, "node-7"));
  EXPECT_EQ(answer.outcome(), v1::EnrolAnswer::TRY_AGAIN);
  EXPECT_THAT(answer.text(), HasSubstr("no space left"));
  EXPECT_FALSE(registry_.keys().find(node));
  full_ = false;
  EXPECT_EQ(enrol(first_, request(node, "node-7")).outcome(), v1::EnrolAnswer::ENROLLED);
  EXPECT_TRUE(registry_.keys().admitted(node));
}

TEST_F(KeyRegistryTest, NoListedKeyGetsAnotherRole) {
  for (const std::string& key : {alice_, first_, second_, wall_}) {
    EXPECT_EQ(enrol(first_, request(key, "eve")).outcome(), v1::EnrolAnswer::REFUSED);
  }
  EXPECT_EQ(registry_.keys().find(alice_)->role, Role::submitter);
  EXPECT_EQ(writes_, 0);
}

TEST_F(KeyRegistryTest, NamesAreSoundAndBelongToOneKey) {
  enrol(second_, request(new_key(), "node-7"));
  for (const std::string& name :
       std::vector<std::string>{"", "node 8", "a\nb", "\x1b[2J", "../x", "token=x",
                                std::string(65, 'a'), "node-7", "alice"}) {
    const v1::EnrolAnswer answer = enrol(first_, request(new_key(), name));
    EXPECT_EQ(answer.outcome(), v1::EnrolAnswer::REFUSED) << name;
    EXPECT_THAT(answer.text(), HasSubstr("name"));
  }
  EXPECT_EQ(writes_, 1);
  // That of a token is free.
  EXPECT_EQ(enrol(first_, request(new_key(), "rack-1")).outcome(), v1::EnrolAnswer::ENROLLED);
}

TEST_F(KeyRegistryTest, WhatIsNoKeyIsRefused) {
  const std::string key = new_key();
  for (const std::string& text : {std::string(), key + "0", key.substr(1), "G" + key.substr(1)}) {
    EXPECT_EQ(enrol(first_, request(text, "node-7")).outcome(), v1::EnrolAnswer::REFUSED) << text;
  }
  EXPECT_EQ(writes_, 0);
}

TEST_F(KeyRegistryTest, ARevokedKeyStaysOutItsTokenUsedAndItsNameFree) {
  const std::string node = new_key();
  enrol(first_, request(node, "node-7"));
  registry_.set_listed(listed(node + " revoked node-7\n"));
  EXPECT_FALSE(registry_.keys().admitted(node));
  EXPECT_EQ(enrol(first_, request(node, "node-7")).outcome(), v1::EnrolAnswer::REFUSED);
  EXPECT_EQ(enrol(first_, request(new_key(), "node-8")).outcome(), v1::EnrolAnswer::TOKEN_USED);
  EXPECT_EQ(enrol(second_, request(new_key(), "node-7")).outcome(), v1::EnrolAnswer::ENROLLED);
  registry_ = opened(node + " revoked node-7\n");
  EXPECT_FALSE(registry_.keys().admitted(node));
}

TEST_F(KeyRegistryTest, OthersStayWhenTheListIsReadAgain) {
  const std::string node = new_key();
  enrol(first_, request(node, "node-7"));
  registry_.set_listed(AllowList::parse(alice_ + " submitter alice\n", "farm.allow"));
  EXPECT_TRUE(registry_.keys().admitted(node));
  EXPECT_EQ(registry_.keys().size(), 2u);
}

TEST_F(KeyRegistryTest, TokensNeedAPlaceForWhatTheyEnrol) {
  EXPECT_THAT(usage_error_of([&] { KeyRegistry{listed()}; }), HasSubstr("--enrolled or --store"));
  KeyRegistry none{AllowList::parse(alice_ + " submitter alice\n", "farm.allow")};
  EXPECT_THROW(none.set_listed(listed()), Error);
  EXPECT_TRUE(none.keys().admitted(alice_));
  EXPECT_EQ(none.keys().size(), 1u);
}

TEST_F(KeyRegistryTest, ADamagedFileIsToldWithItsPlace) {
  enrol(first_, request(new_key(), "node-7"));
  file_ = file_.substr(0, 50);
  EXPECT_THAT(usage_error_of([&] { opened(); }), HasSubstr("enrolled.allow:1:"));
}

}  // namespace
}  // namespace tessera
