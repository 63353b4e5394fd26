#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace tessera {

/// The name of a blob: BLAKE2b-256 (RFC 7693) of its bytes or, where they are more than one chunk,
/// of its chunks' digests one behind another, personalised so that no blob of digests has that
/// name. A value; safe to share between threads.
struct Digest {
  static constexpr size_t kChunkBytes = size_t{1} << 20;

  std::array<uint8_t, 32> bytes{};

  /// Chunks are worked out by several threads.
  static Digest of(std::span<const std::byte> data);
  static Digest of(std::string_view data) { return of(std::as_bytes(std::span(data))); }
  /// From 64 lower-case hexadecimal digits; nothing for any other text.
  static std::optional<Digest> parse(std::string_view hex);
  /// All zero, which names nothing, for any other text.
  static Digest from_hex(std::string_view hex) { return parse(hex).value_or(Digest{}); }
  std::string hex() const;

  friend auto operator<=>(const Digest&, const Digest&) = default;
};

/// The digest of bytes that come piece by piece.
class DigestStream {
 public:
  DigestStream();
  void add(std::span<const std::byte> data);
  /// Of all that was added; call once, at the end.
  Digest finish();

 private:
  /// libsodium's state, which wants to lie so.
  struct alignas(64) State : std::array<std::byte, 384> {};

  void end_chunk();

  State chunk_;            ///< of the last, which may be full
  State chunks_;           ///< of the digests of those before
  size_t in_chunk_ = 0;    ///< bytes
  bool has_more_ = false;  ///< there are chunks before
};

/// SHA-256 (FIPS 180-4) as 64 hexadecimal digits: the form in which pictures are compared.
std::string sha256_hex(std::span<const std::byte> data);

}  // namespace tessera

template <>
struct std::hash<tessera::Digest> {
  size_t operator()(const tessera::Digest& digest) const noexcept {
    size_t value;
    std::memcpy(&value, digest.bytes.data(), sizeof value);
    return value;
  }
};
