#include "base/blake2b_lanes.h"

#include <cstdint>
#include <cstring>

namespace tessera {

#if defined(__x86_64__)
namespace {

constexpr size_t kBlockBytes = 128, kWords = 8;
constexpr int kRounds = 12;

// RFC 7693, section 2.6 and 2.7: the initial state, and the order of a block's words in each round.
constexpr uint64_t kInitial[kWords] = {0x6a09e667f3bcc908, 0xbb67ae8584caa73b, 0x3c6ef372fe94f82b,
                                       0xa54ff53a5f1d36f1, 0x510e527fade682d1, 0x9b05688c2b3e6c1f,
                                       0x1f83d9abfb41bd6b, 0x5be0cd19137e2179};
constexpr uint8_t kOrder[10][16] = {{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15},
                                    {14, 10, 4, 8, 9, 15, 13, 6, 1, 12, 0, 2, 11, 7, 5, 3},
                                    {11, 8, 12, 0, 5, 2, 15, 13, 10, 14, 3, 6, 7, 1, 9, 4},
                                    {7, 9, 3, 1, 13, 12, 11, 14, 2, 6, 5, 10, 4, 0, 15, 8},
                                    {9, 0, 5, 7, 2, 4, 10, 15, 14, 1, 11, 12, 6, 8, 3, 13},
                                    {2, 12, 6, 10, 0, 11, 8, 3, 4, 13, 7, 5, 15, 14, 1, 9},
                                    {12, 5, 1, 15, 14, 13, 4, 10, 0, 7, 6, 3, 9, 2, 8, 11},
                                    {13, 11, 7, 14, 12, 1, 3, 9, 5, 0, 15, 4, 8, 6, 2, 10},
                                    {6, 15, 14, 9, 11, 3, 0, 8, 12, 2, 13, 7, 1, 4, 10, 5},
                                    {10, 2, 8, 4, 7, 6, 1, 5, 15, 11, 9, 14, 3, 12, 13, 0}};

/// One word of each of four messages.
using Four = uint64_t __attribute__((vector_size(32)));
#define TESSERA_IN_LANES __attribute__((target("avx2"), always_inline)) inline

template <int kBits>
TESSERA_IN_LANES void turn_right(Four& word) {
  word = word >> kBits | word << (64 - kBits);
}

TESSERA_IN_LANES void mix(Four& a, Four& b, Four& c, Four& d, const Four& x, const Four& y) {
  a += b + x;
  d ^= a;
  turn_right<32>(d);
  c += d;
  b ^= c;
  turn_right<24>(b);
  a += b + y;
  d ^= a;
  turn_right<16>(d);
  c += d;
  b ^= c;
  turn_right<63>(b);
}

TESSERA_IN_LANES void mix_round(Four v[16], const Four block[16], const uint8_t order[16]) {
  for (int i = 0; i < 4; ++i) {
    mix(v[i], v[4 + i], v[8 + i], v[12 + i], block[order[2 * i]], block[order[2 * i + 1]]);
  }
  for (int i = 0; i < 4; ++i) {
    mix(v[i], v[4 + (i + 1) % 4], v[8 + (i + 2) % 4], v[12 + (i + 3) % 4], block[order[8 + 2 * i]],
        block[order[9 + 2 * i]]);
  }
}

uint64_t word_at(const std::byte* at) {
  uint64_t word;
  std::memcpy(&word, at, sizeof word);
  return word;
}

}  // namespace

__attribute__((target("avx2"))) std::array<Digest, 4> blake2b_of_four(
    const std::array<const std::byte*, 4>& messages, size_t length) {
  Four state[kWords];
  for (size_t i = 0; i < kWords; ++i) state[i] = Four{} + kInitial[i];
  // The parameter block: 32 bytes of digest, no key, neither fan-out nor depth.
  state[0] ^= Four{} + 0x01010020;
  for (size_t at = 0; at < length; at += kBlockBytes) {
    Four block[16], v[16];
    for (size_t i = 0; i < 16; ++i) {
      const size_t place = at + 8 * i;
      block[i] = Four{word_at(messages[0] + place), word_at(messages[1] + place),
                      word_at(messages[2] + place), word_at(messages[3] + place)};
    }
    for (size_t i = 0; i < kWords; ++i) v[i] = state[i], v[kWords + i] = Four{} + kInitial[i];
    v[12] ^= Four{} + (at + kBlockBytes);
    if (at + kBlockBytes == length) v[14] = ~v[14];
    for (int i = 0; i < kRounds; ++i) mix_round(v, block, kOrder[i % 10]);
    for (size_t i = 0; i < kWords; ++i) state[i] ^= v[i] ^ v[kWords + i];
  }
  std::array<Digest, 4> digests;
  for (size_t lane = 0; lane < 4; ++lane) {
    for (size_t i = 0; i < 4; ++i) {
      const uint64_t word = state[i][lane];
      std::memcpy(digests[lane].bytes.data() + 8 * i, &word, sizeof word);
    }
  }
  return digests;
}

bool has_blake2b_lanes() {
  static const bool has = __builtin_cpu_supports("avx2");
  return has;
}
#else
std::array<Digest, 4> blake2b_of_four(const std::array<const std::byte*, 4>&, size_t) { return {}; }
bool has_blake2b_lanes() { return false; }
#endif

}  // namespace tessera
