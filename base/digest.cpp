#include "base/digest.h"

#include <sodium.h>

#include <type_traits>

namespace tessera {
namespace {

std::string to_hex(std::span<const uint8_t> bytes) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  text.reserve(bytes.size() * 2);
  for (const uint8_t byte : bytes) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return -1;
}

const unsigned char* as_octets(std::span<const std::byte> data) {
  return reinterpret_cast<const unsigned char*>(data.data());
}

}  // namespace

Digest Digest::of(std::span<const std::byte> data) {
  Digest digest;
  crypto_generichash(digest.bytes.data(), digest.bytes.size(), as_octets(data), data.size(),
                     nullptr, 0);
  return digest;
}

static_assert(sizeof(crypto_generichash_state) == sizeof(DigestStream));
static_assert(std::is_trivially_copyable_v<crypto_generichash_state>);

DigestStream::DigestStream() {
  crypto_generichash_init(reinterpret_cast<crypto_generichash_state*>(state_.data()), nullptr, 0,
                          sizeof(Digest::bytes));
}

void DigestStream::add(std::span<const std::byte> data) {
  crypto_generichash_update(reinterpret_cast<crypto_generichash_state*>(state_.data()),
                            as_octets(data), data.size());
}

Digest DigestStream::finish() {
  Digest digest;
  crypto_generichash_final(reinterpret_cast<crypto_generichash_state*>(state_.data()),
                           digest.bytes.data(), digest.bytes.size());
  return digest;
}

std::optional<Digest> Digest::parse(std::string_view hex) {
  Digest digest;
  if (hex.size() != 2 * digest.bytes.size()) return std::nullopt;
  for (size_t i = 0; i < digest.bytes.size(); ++i) {
    const int high = hex_digit(hex[2 * i]);
    const int low = hex_digit(hex[2 * i + 1]);
    if (high < 0 || low < 0) return std::nullopt;
    digest.bytes[i] = static_cast<uint8_t>(high << 4 | low);
  }
  return digest;
}

std::string Digest::hex() const { return to_hex(bytes); }

std::string sha256_hex(std::span<const std::byte> data) {
  std::array<uint8_t, crypto_hash_sha256_BYTES> hash;
  crypto_hash_sha256(hash.data(), as_octets(data), data.size());
  return to_hex(hash);
}

}  // namespace tessera
