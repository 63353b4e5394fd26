#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "image/channel/image_channel.h"
#include "image/channel/sealed_memory.h"
#include "renderer/math/stored_samples.h"

namespace tessera {

/// What the image codec answers where nothing fails.
struct ImageAnswer {
  PixelLayout layout;
  std::vector<char> payload;
  std::optional<SealedMemory> shared{};  ///< in place of the payload
  SampleMeaning meaning{};               ///< of what was decoded
  std::string names{};                   ///< of channels, each ended by a zero
  std::string part{};                    ///< of OpenEXR, where it is not the first
  std::string damage{};                  ///< as ImageReply has it
  float gamma = 0;                       ///< likewise

  /// Where the pixels of `layout` go. Large ones are shared: each such picture costs whoever asked
  /// a descriptor, a smaller one a copy.
  std::span<char> make_room() {
    constexpr uint64_t kLeastShared = uint64_t{16} << 20;
    if (layout.bytes() >= kLeastShared) shared = SealedMemory::create(layout.bytes());
    if (!shared) payload.resize(layout.bytes());
    return pixels();
  }
  std::span<char> pixels() { return shared ? shared->bytes() : std::span<char>(payload); }
};

/// The cause becomes the answer.
[[noreturn]] inline void fail_image(const std::string& cause) { throw std::runtime_error(cause); }

/// Names of channels as ImageAnswer has them. Fails where they are longer than an answer's may be.
inline std::string joined_names(const std::vector<std::string>& names) {
  std::string all;
  for (const std::string& name : names) {
    if (all.size() + name.size() >= PixelLayout::kLongestNames) {
      fail_image("its channels have too long names");
    }
    all.append(name.c_str()).push_back('\0');
  }
  return all;
}

}  // namespace tessera
