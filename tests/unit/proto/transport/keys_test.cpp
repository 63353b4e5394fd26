#include "proto/transport/keys.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "proto/transport/allow_list.h"
#include "tests/error_of.h"

namespace tessera {
namespace {

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
  EXPECT_THAT(error(key + " worker a b"), HasSubstr("farm.allow:1:75: 4 words"));
  EXPECT_THAT(error(key + " worker a\x1b[2J"),
              AllOf(HasSubstr(":1:73: name"), Not(HasSubstr("\x1b"))));
  EXPECT_THAT(error(key + " worker a\n" + key + " viewer b"),
              HasSubstr("farm.allow:2:1: this key"));
}

}  // namespace
}  // namespace tessera
