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

/// The name of a blob: BLAKE2b-256 of its bytes (RFC 7693). A value; safe to share between threads.
struct Digest {
  std::array<uint8_t, 32> bytes{};

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
  // libsodium's state, which wants to lie so.
  alignas(64) std::array<std::byte, 384> state_;
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
