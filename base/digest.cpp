#include "base/digest.h"

#include <sodium.h>

#include <algorithm>
#include <type_traits>
#include <vector>

#include "base/cancellation.h"
#include "base/hex.h"
#include "base/parallel.h"
#include "base/process.h"

namespace tessera {
namespace {

const unsigned char* as_octets(std::span<const std::byte> data) {
  return reinterpret_cast<const unsigned char*>(data.data());
}

template <typename State>
crypto_generichash_state* as_sodium(State& state) {
  static_assert(sizeof(crypto_generichash_state) == sizeof(State));
  static_assert(std::is_trivially_copyable_v<crypto_generichash_state>);
  return reinterpret_cast<crypto_generichash_state*>(state.data());
}

/// libsodium takes its portable code, half as fast, unless it was told to look at the processor.
void choose_implementation() { [[maybe_unused]] static const int done = sodium_init(); }

void begin(crypto_generichash_state* state) {
  choose_implementation();
  crypto_generichash_init(state, nullptr, 0, sizeof(Digest::bytes));
}

void begin_tree(crypto_generichash_state* state) {
  constexpr std::array<unsigned char, crypto_generichash_blake2b_PERSONALBYTES> kPersonal{
      't', 'e', 's', 's', 'e', 'r', 'a', ' ', 'c', 'h', 'u', 'n', 'k', 's'};
  crypto_generichash_blake2b_init_salt_personal(state, nullptr, 0, sizeof(Digest::bytes), nullptr,
                                                kPersonal.data());
}

Digest finished(crypto_generichash_state* state) {
  Digest digest;
  crypto_generichash_final(state, digest.bytes.data(), digest.bytes.size());
  return digest;
}

Digest of_chunk(std::span<const std::byte> chunk) {
  choose_implementation();
  Digest digest;
  crypto_generichash(digest.bytes.data(), digest.bytes.size(), as_octets(chunk), chunk.size(),
                     nullptr, 0);
  return digest;
}

}  // namespace

Digest Digest::of(std::span<const std::byte> data) {
  if (data.size() <= kChunkBytes) return of_chunk(data);
  std::vector<Digest> chunks((data.size() + kChunkBytes - 1) / kChunkBytes);
  for_each_piece_parallel(data.size(), kChunkBytes, core_count(), [&](size_t from, size_t to) {
    chunks[from / kChunkBytes] = of_chunk(data.subspan(from, to - from));
  });
  crypto_generichash_state state;
  begin_tree(&state);
  for (const Digest& chunk : chunks)
    crypto_generichash_update(&state, chunk.bytes.data(), chunk.bytes.size());
  return finished(&state);
}

DigestStream::DigestStream() {
  begin(as_sodium(chunk_));
  begin_tree(as_sodium(chunks_));
}

void DigestStream::end_chunk() {
  const Digest chunk = finished(as_sodium(chunk_));
  crypto_generichash_update(as_sodium(chunks_), chunk.bytes.data(), chunk.bytes.size());
  has_more_ = true;
}

void DigestStream::add(std::span<const std::byte> data) {
  while (!data.empty()) {
    if (in_chunk_ == Digest::kChunkBytes) {
      end_chunk();
      begin(as_sodium(chunk_));
      in_chunk_ = 0;
    }
    const auto part = data.first(std::min(data.size(), Digest::kChunkBytes - in_chunk_));
    crypto_generichash_update(as_sodium(chunk_), as_octets(part), part.size());
    in_chunk_ += part.size();
    data = data.subspan(part.size());
  }
}

Digest DigestStream::finish() {
  if (!has_more_) return finished(as_sodium(chunk_));
  end_chunk();
  return finished(as_sodium(chunks_));
}

std::optional<Digest> Digest::parse(std::string_view hex) {
  Digest digest;
  if (!parse_hex(hex, digest.bytes)) return std::nullopt;
  return digest;
}

std::string Digest::hex() const { return hex_text(bytes); }

std::string sha256_hex(std::span<const std::byte> data) {
  crypto_hash_sha256_state state;
  crypto_hash_sha256_init(&state);
  constexpr size_t kBytesBetweenLooks = size_t{1} << 22;
  while (!data.empty()) {
    Cancellation::check();
    const auto some = data.first(std::min(data.size(), kBytesBetweenLooks));
    crypto_hash_sha256_update(&state, as_octets(some), some.size());
    data = data.subspan(some.size());
  }
  std::array<uint8_t, crypto_hash_sha256_BYTES> hash;
  crypto_hash_sha256_final(&state, hash.data());
  return hex_text(hash);
}

}  // namespace tessera
