#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "base/bytes.h"
#include "proto/tessera/v1/farm.pb.h"

namespace tessera {

/// One message as it travels: a header of 16 bytes, then the serialised Envelope.
///   0  magic "TSRA"    4  frame version 1    5  three zero bytes
///   8  length of the Envelope, u32 LE       12  CRC32C of the Envelope, u32 LE
using Frame = Bytes;

inline constexpr size_t kFrameHeaderSize = 16;
/// The longest whole frame that is ever made; each channel has its own bound on what it takes.
inline constexpr size_t kMaxFrame = size_t{4} << 20;

/// Broken promise if the message exceeds kMaxFrame.
Frame encode(const v1::Envelope& message);

/// How long the frame is that begins so; nothing if no frame does. decode() checks it.
std::optional<size_t> frame_length(std::span<const std::byte> begin);

/// Nothing if `frame` is longer than `limit`, damaged, nested too deeply or no Envelope.
/// Never throws on account of what the bytes say.
std::optional<v1::Envelope> decode(std::span<const std::byte> frame, size_t limit);

}  // namespace tessera
