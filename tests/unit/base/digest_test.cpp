#include "base/digest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace tessera {
namespace {

TEST(Digest, IsBlake2b256) {
  EXPECT_EQ(Digest::of("abc").hex(),
            "bddd813c634239723171ef3fee98579b94964e3bb1cb3e427262c8c068d52319");
}

std::vector<std::byte> some_bytes(size_t size) {
  std::vector<std::byte> bytes(size);
  for (size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(i * i >> 7);
  return bytes;
}

TEST(Digest, OfChunksIsThatOfTheirDigests) {
  // By Python's hashlib: blake2b(b"".join(blake2b(chunk, 32)), 32, person=b"tessera chunks").
  EXPECT_EQ(Digest::of(some_bytes(Digest::kChunkBytes)).hex(),
            "10912acbaf7bbcc6d5e5c9f0cfb2ad17ec6e1cf0b01be2455b42fc24b4d96392");
  EXPECT_EQ(Digest::of(some_bytes(Digest::kChunkBytes + 1)).hex(),
            "513fd25665e27f304c351f3fb797c9e94f3762284cb6a9efccd24bff006d41a0");
  EXPECT_EQ(Digest::of(some_bytes(5 * Digest::kChunkBytes)).hex(),
            "a98b0a0328b7b174205f6272551d04e6a1d284617a49e78d0c372c82dde919ec");
}

TEST(Digest, OfPiecesIsThatOfTheWhole) {
  for (const size_t size :
       {size_t{0}, size_t{1}, Digest::kChunkBytes - 1, Digest::kChunkBytes, Digest::kChunkBytes + 1,
        3 * Digest::kChunkBytes, 3 * Digest::kChunkBytes + 7}) {
    const std::vector<std::byte> bytes = some_bytes(size);
    for (const size_t piece : {size_t{300'007}, Digest::kChunkBytes, size_t{2'500'000}}) {
      DigestStream stream;
      for (size_t at = 0; at < size; at += piece)
        stream.add(std::span(bytes).subspan(at, std::min(piece, size - at)));
      EXPECT_EQ(stream.finish(), Digest::of(bytes)) << size << " by " << piece;
    }
  }
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
