#pragma once

#include <span>
#include <string_view>

#include "proto/transport/transport.h"

namespace tessera {

/// A message that says that.
inline MessageBytes bytes_of(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

}  // namespace tessera
