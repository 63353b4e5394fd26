#include "base/digest.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

TEST(Digest, IsBlake2b256) {
  EXPECT_EQ(Digest::of("abc").hex(),
            "bddd813c634239723171ef3fee98579b94964e3bb1cb3e427262c8c068d52319");
}

TEST(Digest, ParsesWhatItPrintsAndNothingElse) {
  const Digest digest = Digest::of("tile");
  EXPECT_EQ(Digest::parse(digest.hex()), digest);
  EXPECT_EQ(Digest::parse(digest.hex().substr(1)), std::nullopt);
  EXPECT_EQ(Digest::parse(std::string(64, 'g')), std::nullopt);
  EXPECT_EQ(Digest::parse(std::string(64, 'A')), std::nullopt);
}

TEST(Sha256, KnownAnswer) {
  const std::string_view text = "abc";
  EXPECT_EQ(sha256_hex(std::as_bytes(std::span(text))),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

}  // namespace
}  // namespace tessera
