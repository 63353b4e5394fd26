#pragma once

#include <cstdint>
#include <optional>

#include "renderer/sampler/sampler.h"
#include "renderer/scene/skips.h"

namespace tessera {

/// Bounces that no roulette ends.
inline constexpr uint32_t kSafeDepth = 3;

/// The numbers that one vertex of a path draws; what it does not ask for is not worked out.
class VertexNumbers {
 public:
  /// Pairs, by what they are for.
  enum Pair : uint32_t { kOnLight, kDirection, kChoice, kPick, kPairs };
  /// That of SampleStream::pair().
  static uint32_t use_of(uint32_t vertex, uint32_t pair) {
    constexpr uint32_t kFirst = 1u << 20;
    return kFirst + kPairs * vertex + pair;
  }

  VertexNumbers(const SampleStream& stream, uint32_t vertex, bool skips, uint64_t& skipped)
      : stream_(stream), vertex_(vertex), skips_(skips), skipped_(skipped) {}
  ~VertexNumbers() {
    if (skips_) {
      skipped_ += kPairs - ((read_ & 1) + (read_ >> 1 & 1) + (read_ >> 2 & 1) + (read_ >> 3));
    } else {
      read_others();
    }
  }
  VertexNumbers(const VertexNumbers&) = delete;
  VertexNumbers& operator=(const VertexNumbers&) = delete;

  /// The direction's, which nearly every vertex asks for: hashed while the way to the vertex is
  /// traced, it keeps nobody waiting.
  void draw_ahead() const { direction_ = pair(kDirection); }
  Vec2 on_light() const {
    if (!direction_) draw_ahead();  // side by side
    return pair(kOnLight);
  }
  Vec2 direction() const { return direction_ ? *direction_ : pair(kDirection); }
  /// x: which way to scatter, y: whether to go on.
  Vec2 choice() const { return pair(kChoice); }
  /// x: which light, y: whether the surface is passed.
  Vec2 pick() const { return pair(kPick); }

 private:
  Vec2 pair(uint32_t use) const {
    read_ |= 1u << use;
    return stream_.pair(static_cast<SampleUse>(use_of(vertex_, use)));
  }
  [[gnu::cold, gnu::noinline]] void read_others() const {
    for (uint32_t use = 0; use < kPairs; ++use) {
      if ((read_ >> use & 1) != 0) continue;
      keep_result(pair(use));
    }
  }

  const SampleStream& stream_;
  uint32_t vertex_;
  bool skips_;
  uint64_t& skipped_;  ///< counts pairs that were not asked for
  mutable uint32_t read_ = 0;
  mutable std::optional<Vec2> direction_;
};

}  // namespace tessera
