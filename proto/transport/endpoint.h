#pragma once

#include <string>

namespace tessera {

/// ipc://PATH or tcp://HOST:PORT in its parts.
struct Endpoint {
  bool tcp = false;
  std::string path;  ///< ipc
  std::string host;  ///< tcp; an IPv6 address stands in brackets
  int port = 0;      ///< tcp; 0: any that is free

  std::string str() const;
  /// Whether only this machine can reach it.
  bool loopback() const;
};

/// Throws usage_error for any other text.
Endpoint parse_endpoint(const std::string& text);

}  // namespace tessera
