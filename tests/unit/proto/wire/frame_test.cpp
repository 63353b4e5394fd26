#include "proto/wire/frame.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "proto/wire/crc32c.h"

namespace tessera {
namespace {

std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text));
}

v1::Envelope heartbeat() {
  v1::Envelope message;
  message.mutable_heartbeat()->set_session(7);
  for (uint64_t lease = 1; lease < 20; ++lease) {
    message.mutable_heartbeat()->add_progress()->set_lease(lease);
  }
  return message;
}

/// The frame of bytes that need be no Envelope.
Frame frame_of(std::string_view body) {
  Frame frame(kFrameHeaderSize + body.size());
  std::memcpy(frame.data(), "TSRA\1\0\0\0", 8);
  const auto length = static_cast<uint32_t>(body.size());
  const uint32_t crc = crc32c(bytes_of(body));
  std::memcpy(frame.data() + 8, &length, 4);
  std::memcpy(frame.data() + 12, &crc, 4);
  std::memcpy(frame.data() + kFrameHeaderSize, body.data(), body.size());
  return frame;
}

TEST(Crc32c, KnownAnswers) {
  EXPECT_EQ(crc32c(bytes_of("123456789")), 0xe3069283u);
  EXPECT_EQ(crc32c(bytes_of("")), 0u);
  // RFC 3720, B.4: 32 bytes of zeros, and of ones.
  EXPECT_EQ(crc32c(std::vector<std::byte>(32)), 0x8a9136aau);
  EXPECT_EQ(crc32c(std::vector<std::byte>(32, std::byte{0xff})), 0x62a8ab43u);
}

// Long data go three blocks at a time.
TEST(Crc32c, IsThatOfItsDefinitionAtEveryLength) {
  const auto by_definition = [](std::span<const std::byte> data) {
    uint32_t crc = ~0u;
    for (const std::byte byte : data) {
      crc ^= static_cast<uint32_t>(byte);
      for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0x82f63b78u : 0);
    }
    return ~crc;
  };
  std::vector<std::byte> data(20'000);
  uint32_t state = 1;
  for (std::byte& byte : data) byte = static_cast<std::byte>((state = state * 1664525 + 1) >> 24);
  for (const size_t size : {6143, 6144, 6145, 6151, 6152, 8192, 12287, 12288, 18432, 20000}) {
    const auto part = std::span(data).first(size);
    EXPECT_EQ(crc32c(part), by_definition(part)) << size;
  }
}

TEST(Frame, ComesBackAsItWent) {
  const auto message = decode(encode(heartbeat()), kMaxFrame);
  ASSERT_TRUE(message);
  EXPECT_EQ(message->SerializeAsString(), heartbeat().SerializeAsString());
}

TEST(Frame, IsRefusedWhenTruncatedAnywhere) {
  const Frame frame = encode(heartbeat());
  for (size_t length = 0; length < frame.size(); ++length) {
    EXPECT_FALSE(decode(std::span(frame).first(length), kMaxFrame)) << length;
  }
}

TEST(Frame, IsRefusedWithAnyBitFlipped) {
  const Frame frame = encode(heartbeat());
  for (size_t bit = 0; bit < frame.size() * 8; ++bit) {
    Frame damaged = frame;
    damaged[bit / 8] ^= static_cast<std::byte>(1u << bit % 8);
    EXPECT_FALSE(decode(damaged, kMaxFrame)) << bit;
  }
}

TEST(Frame, IsRefusedWhenTooLong) {
  const Frame frame = encode(heartbeat());
  EXPECT_TRUE(decode(frame, frame.size()));
  EXPECT_FALSE(decode(frame, frame.size() - 1));
}

TEST(Frame, IsRefusedWithAnythingBehindIt) {
  Frame frame = encode(heartbeat());
  frame.push_back(std::byte{0});
  EXPECT_FALSE(decode(frame, kMaxFrame));
}

TEST(Frame, IsRefusedWithoutAMessage) { EXPECT_FALSE(decode(frame_of(""), kMaxFrame)); }

TEST(Frame, OfAMessageUnknownHereIsRefused) {
  // Field 100, length 0: from a newer minor version, or nobody.
  EXPECT_FALSE(decode(frame_of("\xa2\x06\x00"), kMaxFrame));
}

TEST(Frame, NestedTooDeeplyIsRefused) {
  // A group in a group in a group ... of an unknown field.
  EXPECT_FALSE(decode(frame_of(std::string(1000, '\x0b') + std::string(1000, '\x0c')), kMaxFrame));
}

TEST(Frame, OfRandomBytesNeverThrows) {
  std::mt19937 random(1);
  for (int i = 0; i < 20000; ++i) {
    std::string body(random() % 64, '\0');
    for (char& c : body) c = static_cast<char>(random());
    EXPECT_NO_THROW(decode(frame_of(body), kMaxFrame));
  }
}

}  // namespace
}  // namespace tessera
