#include "proto/transport/keys.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "proto/transport/allow_list.h"
#include "tests/error_of.h"

namespace tessera {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(Keys, AreReadAsTheyWereWritten) {
  const KeyPair keys = make_key_pair();
  EXPECT_NE(keys.public_key, make_key_pair().public_key);
  const KeyPair read = parse_secret_key_file(secret_key_file(keys, "node-1"), "f");
  EXPECT_EQ(read.secret_key, keys.secret_key);
  EXPECT_EQ(read.public_key, keys.public_key);
  EXPECT_EQ(parse_key(key_text(keys.public_key)), keys.public_key);
}

TEST(Keys, OtherTextsAreNone) {
  const std::string good = key_text(make_key_pair().public_key);
  EXPECT_FALSE(parse_key(good.substr(1)));
  EXPECT_FALSE(parse_key(good + "0"));
  EXPECT_FALSE(parse_key("g" + good.substr(1)));
  EXPECT_FALSE(parse_key("A" + good.substr(1)));
}

TEST(Keys, AWrongSecretIsToldWithItsPlaceAndNotShown) {
  const std::string secret = key_text(make_key_pair().secret_key);
  for (const std::string& text :
       {"# x\n  " + secret, "secret " + secret + " more", "\n\nsecret " + secret.substr(2),
        "secret " + secret + "\nsecret " + secret}) {
    EXPECT_THAT(usage_error_of([&] { parse_secret_key_file(text, "node.key"); }),
                AllOf(HasSubstr("node.key:"), Not(HasSubstr(secret.substr(10, 20)))));
  }
  EXPECT_THAT(usage_error_of([] { parse_secret_key_file("# nothing\n", "node.key"); }),
              HasSubstr("no key"));
}

TEST(AllowList, HasRolesAndNames) {
  const Key one = make_key_pair().public_key, two = make_key_pair().public_key;
  const AllowList list =
      AllowList::parse("# the farm\n\n" + AllowList::line(one, {Role::worker, "node-1"}) + "\t" +
                           key_text(two) + "  viewer\twall.2 # on the wall\r\n",
                       "farm.allow");
  EXPECT_EQ(list.size(), 2u);
  ASSERT_TRUE(list.find(key_text(one)) && list.find(key_text(two)));
  EXPECT_EQ(list.find(key_text(one))->role, Role::worker);
  EXPECT_EQ(list.find(key_text(one))->name, "node-1");
  EXPECT_EQ(list.find(key_text(two))->role, Role::viewer);
  EXPECT_EQ(list.find(key_text(two))->name, "wall.2");
  EXPECT_FALSE(list.find(""));
  EXPECT_FALSE(list.find(key_text(make_key_pair().public_key)));
}

TEST(Keys, OfAFileOfSeveralAllAreRead) {
  const std::vector<KeyPair> keys{make_key_pair(), make_key_pair()};
  const std::string text = secret_keys_file(keys, "tokens");
  const std::vector<KeyPair> read = parse_secret_keys_file(text, "f");
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[0].public_key, keys[0].public_key);
  EXPECT_EQ(read[1].secret_key, keys[1].secret_key);
  EXPECT_THAT(usage_error_of([&] { parse_secret_key_file(text, "f"); }),
              HasSubstr("2 secret keys; expected one"));
}

constexpr WallTime kNoon = std::chrono::sys_days(std::chrono::year(2026) / 11 / 24) + 12h;

TEST(AllowList, AKeyIsLetInUntilItsTimeIsOver) {
  const std::string key = key_text(make_key_pair().public_key);
  const AllowList list =
      AllowList::parse(key + " enrol:worker rack-1 until=2026-11-24T12:00:00Z", "farm.allow");
  ASSERT_TRUE(list.find(key));
  EXPECT_EQ(list.find(key)->role, Role::enrol);
  EXPECT_EQ(list.find(key)->grants, Role::worker);
  EXPECT_EQ(list.find(key)->until, kNoon);
  EXPECT_TRUE(list.admitted(key, kNoon - 1s));
  EXPECT_FALSE(list.admitted(key, kNoon));
  EXPECT_FALSE(list.admitted(key, kNoon + 1s));
}

TEST(AllowList, ARevokedKeyIsNeverLetIn) {
  const std::string key = key_text(make_key_pair().public_key);
  AllowList list = AllowList::parse(key + " revoked node-1", "farm.allow");
  EXPECT_TRUE(list.find(key));
  EXPECT_FALSE(list.admitted(key, kNoon));
  list.add(AllowList::parse(key + " worker node-1", "enrolled.allow"));
  EXPECT_FALSE(list.admitted(key, kNoon));
}

TEST(AllowList, KeysOfAnotherListShadowNone) {
  const std::string key = key_text(make_key_pair().public_key);
  const std::string other = key_text(make_key_pair().public_key);
  AllowList list = AllowList::parse(key + " viewer wall", "farm.allow");
  list.add(AllowList::parse(key + " submitter eve\n" + other + " worker node", "enrolled.allow"));
  EXPECT_EQ(list.size(), 2u);
  EXPECT_EQ(list.find(key)->role, Role::viewer);
  EXPECT_EQ(list.find(key)->name, "wall");
  EXPECT_EQ(list.find(other)->role, Role::worker);
}

TEST(AllowList, LinesAreReadAsTheyWereWritten) {
  const Key key = make_key_pair().public_key;
  const std::string token = key_text(make_key_pair().public_key);
  for (const AllowedKey& allowed :
       {AllowedKey{.role = Role::worker, .name = "a"},
        AllowedKey{.role = Role::revoked, .name = "b"},
        AllowedKey{.role = Role::enrol, .name = "c", .grants = Role::submitter, .until = kNoon},
        AllowedKey{.role = Role::worker, .name = "d", .token = token, .since = kNoon}}) {
    const std::string line = AllowList::line(key, allowed);
    const AllowList list = AllowList::parse(line, "f");
    ASSERT_EQ(list.size(), 1u) << line;
    const AllowedKey* read = list.find(key_text(key));
    EXPECT_EQ(read->role, allowed.role) << line;
    EXPECT_EQ(read->grants, allowed.grants) << line;
    EXPECT_EQ(read->name, allowed.name) << line;
    EXPECT_EQ(read->until, allowed.until) << line;
    EXPECT_EQ(read->token, allowed.token) << line;
    EXPECT_EQ(read->since, allowed.since) << line;
  }
}

TEST(AllowList, TellsWhatIsWrongAndWhere) {
  const std::string key = key_text(make_key_pair().public_key);
  const auto error = [&](const std::string& text) {
    return usage_error_of([&] { AllowList::parse(text, "farm.allow"); });
  };
  EXPECT_THAT(error("\n  nonsense worker x"), HasSubstr("farm.allow:2:3: 'nonsense'"));
  EXPECT_THAT(error(key + " workr x"), AllOf(HasSubstr("farm.allow:1:66: role 'workr'"),
                                             HasSubstr("did you mean 'worker'")));
  EXPECT_THAT(error(key + " any x"), HasSubstr("expected worker, submitter, viewer"));
  EXPECT_THAT(error(key + " worker"), HasSubstr("farm.allow:1:66: 2 words"));
  EXPECT_THAT(error(key + " worker a b"), HasSubstr("farm.allow:1:75: 'b'; expected nothing"));
  EXPECT_THAT(error(key + " enrol:wrker a"), AllOf(HasSubstr("farm.allow:1:66: role 'wrker'"),
                                                   HasSubstr("did you mean 'worker'")));
  EXPECT_THAT(error(key + " enrol a"), HasSubstr("farm.allow:1:66: role 'enrol'"));
  for (const char* wrong :
       {"until=", "until=tomorrow", "until=2026-02-30T00:00:00Z", "until=2026-11-24T24:00:00Z",
        "until=2026-11-24T12:00:00", "until=2026-11-24T12:00:00Z+1", "until=2026-1-24T12:00:00Z",
        "since=2026-11-24", "token=aa", "till=2026-11-24T12:00:00Z"}) {
    EXPECT_THAT(error(key + " worker a " + wrong), HasSubstr("farm.allow:1:75: '")) << wrong;
  }
  const std::string twice = " until=2026-11-24T12:00:00Z";
  EXPECT_THAT(error(key + " worker a" + twice + twice), HasSubstr("farm.allow:1:102: 'until="));
  EXPECT_THAT(error(key + " worker a\x1b[2J"),
              AllOf(HasSubstr(":1:73: name"), Not(HasSubstr("\x1b"))));
  EXPECT_THAT(error(key + " worker a\n" + key + " viewer b"),
              HasSubstr("farm.allow:2:1: this key"));
}

}  // namespace
}  // namespace tessera
