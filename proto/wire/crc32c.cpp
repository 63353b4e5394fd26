#include "proto/wire/crc32c.h"

#include <array>
#include <cstring>

namespace tessera {
namespace {

constexpr std::array<uint32_t, 256> make_table() {
  constexpr uint32_t kReversedPolynomial = 0x82f63b78;
  std::array<uint32_t, 256> table{};
  for (uint32_t i = 0; i < 256; ++i) {
    uint32_t crc = i;
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? kReversedPolynomial : 0);
    table[i] = crc;
  }
  return table;
}

uint32_t by_table(uint32_t crc, std::span<const std::byte> data) {
  static constexpr auto kTable = make_table();
  for (const std::byte byte : data) {
    crc = crc >> 8 ^ kTable[(crc ^ static_cast<uint32_t>(byte)) & 255];
  }
  return crc;
}

#if defined(__x86_64__)
constexpr size_t kBlock = 2048;

/// What kBlock zeros make of a state: linear over GF(2), so the sum of what they make of its bytes.
class PastBlock {
 public:
  PastBlock() {
    static constexpr std::array<std::byte, kBlock> kZeros{};
    for (size_t place = 0; place < 4; ++place) {
      auto& made = made_[place];
      for (uint32_t bit = 0; bit < 8; ++bit) {
        const uint32_t one = 1u << bit;
        made[one] = by_table(one << (8 * place), kZeros);
        for (uint32_t below = 1; below < one; ++below) made[one + below] = made[one] ^ made[below];
      }
    }
  }
  uint32_t operator()(uint32_t state) const {
    return made_[0][state & 255] ^ made_[1][state >> 8 & 255] ^ made_[2][state >> 16 & 255] ^
           made_[3][state >> 24];
  }

 private:
  std::array<std::array<uint32_t, 256>, 4> made_{};
};

uint64_t word_at(std::span<const std::byte> data, size_t place) {
  uint64_t word;
  std::memcpy(&word, data.data() + place, sizeof word);
  return word;
}

/// The instruction takes three cycles but can begin in each: so three blocks at a time (Gopal et
/// al., Intel 2011).
__attribute__((target("sse4.2"))) uint32_t by_instruction(uint32_t crc,
                                                          std::span<const std::byte> data) {
  static const PastBlock past_block;
  uint64_t state = crc;
  size_t i = 0;
  for (; i + 3 * kBlock <= data.size(); i += 3 * kBlock) {
    uint64_t second = 0, third = 0;
    for (size_t k = i; k < i + kBlock; k += 8) {
      state = __builtin_ia32_crc32di(state, word_at(data, k));
      second = __builtin_ia32_crc32di(second, word_at(data, k + kBlock));
      third = __builtin_ia32_crc32di(third, word_at(data, k + 2 * kBlock));
    }
    state = past_block(static_cast<uint32_t>(state)) ^ second;
    state = past_block(static_cast<uint32_t>(state)) ^ third;
  }
  for (; i + 8 <= data.size(); i += 8) state = __builtin_ia32_crc32di(state, word_at(data, i));
  auto tail = static_cast<uint32_t>(state);
  for (; i < data.size(); ++i) {
    tail = __builtin_ia32_crc32qi(tail, static_cast<uint8_t>(data[i]));
  }
  return tail;
}
#endif

}  // namespace

uint32_t crc32c(std::span<const std::byte> data) {
#if defined(__x86_64__)
  static const bool has_instruction = __builtin_cpu_supports("sse4.2");
  if (has_instruction) return ~by_instruction(~0u, data);
#endif
  return ~by_table(~0u, data);
}

}  // namespace tessera
