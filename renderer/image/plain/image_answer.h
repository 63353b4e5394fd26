#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "renderer/image/channel/image_channel.h"

namespace tessera {

/// What the image codec answers where nothing fails.
struct ImageAnswer {
  PixelLayout layout;
  std::vector<char> payload;
  bool is_sent = false;  ///< piece by piece, by an ImageStream
};

/// The cause becomes the answer.
[[noreturn]] inline void fail_image(const std::string& cause) { throw std::runtime_error(cause); }

}  // namespace tessera
