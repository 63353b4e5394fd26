#include "proto/wire/frame.h"

#include <fmt/format.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/stubs/logging.h>

#include <bit>
#include <cstdio>
#include <cstring>
#include <string>

#include "base/error.h"
#include "proto/wire/crc32c.h"

namespace tessera {
namespace {

static_assert(std::endian::native == std::endian::little, "headers are written as they lie");

struct Header {
  char magic[4] = {'T', 'S', 'R', 'A'};
  uint8_t version = 1;
  uint8_t zero[3] = {};
  uint32_t length = 0;
  uint32_t crc = 0;
};
static_assert(sizeof(Header) == kFrameHeaderSize);

// The deepest Envelope is one of JobEnd's rectangles: 4.
constexpr int kMaxNesting = 8;

void tell_fatal(google::protobuf::LogLevel level, const char* file, int line,
                const std::string& message) {
  if (level < google::protobuf::LOGLEVEL_FATAL) return;
  std::fprintf(stderr, "%s:%d: %s\n", file, line, message.c_str());
}

/// What is wrong with a message is told by who takes it, not by a library, on standard error, for
/// each that a stranger sends.
void hush_protobuf() {
  static const bool hushed = (google::protobuf::SetLogHandler(&tell_fatal), true);
  static_cast<void>(hushed);
}

}  // namespace

Frame encode(const v1::Envelope& message) {
  hush_protobuf();
  Header header;
  const size_t length = message.ByteSizeLong();
  TESSERA_CHECK(kFrameHeaderSize + length <= kMaxFrame,
                fmt::format("{} bytes, {}", length, kMaxFrame));
  Frame frame(kFrameHeaderSize + length);
  message.SerializeWithCachedSizesToArray(
      reinterpret_cast<uint8_t*>(frame.data() + kFrameHeaderSize));
  header.length = static_cast<uint32_t>(length);
  header.crc = crc32c(std::span(frame).subspan(kFrameHeaderSize));
  std::memcpy(frame.data(), &header, sizeof header);
  return frame;
}

std::optional<size_t> frame_length(std::span<const std::byte> begin) {
  Header header;
  if (begin.size() < sizeof header) return std::nullopt;
  std::memcpy(&header, begin.data(), sizeof header);
  const bool ours = std::memcmp(header.magic, Header().magic, sizeof header.magic) == 0;
  if (!ours || header.length > kMaxFrame - kFrameHeaderSize) return std::nullopt;
  return kFrameHeaderSize + header.length;
}

std::optional<v1::Envelope> decode(std::span<const std::byte> frame, size_t limit) {
  if (frame.size() < kFrameHeaderSize || frame.size() > limit) return std::nullopt;
  Header header;
  const Header expected;
  std::memcpy(&header, frame.data(), sizeof header);
  const auto body = frame.subspan(kFrameHeaderSize);
  if (std::memcmp(header.magic, expected.magic, sizeof header.magic) != 0 ||
      header.version != expected.version ||
      std::memcmp(header.zero, expected.zero, sizeof header.zero) != 0 ||
      header.length != body.size() || header.crc != crc32c(body)) {
    return std::nullopt;
  }
  hush_protobuf();
  google::protobuf::io::CodedInputStream stream(reinterpret_cast<const uint8_t*>(body.data()),
                                                static_cast<int>(body.size()));
  stream.SetRecursionLimit(kMaxNesting);
  std::optional<v1::Envelope> message(std::in_place);
  if (!message->ParseFromCodedStream(&stream) || !stream.ConsumedEntireMessage() ||
      message->message_case() == v1::Envelope::MESSAGE_NOT_SET) {
    return std::nullopt;
  }
  return message;
}

}  // namespace tessera
