#include "proto/transport/endpoint.h"

#include <fmt/format.h>

#include <charconv>

#include "base/error.h"
#include "proto/transport/socket_address.h"

namespace tessera {
namespace {

// sockaddr_un holds 108 bytes; ".bulk" and the final zero must fit too.
constexpr size_t kMaxPath = 102;

[[noreturn]] void malformed(const std::string& text, const char* why) {
  throw usage_error(
      fmt::format("endpoint '{}'{}; expected ipc://PATH or tcp://HOST:PORT", text, why));
}

}  // namespace

std::string Endpoint::str() const {
  if (!tcp) return "ipc://" + path;
  return fmt::format("tcp://{}:{}", host, port == 0 ? "*" : std::to_string(port));
}

bool Endpoint::loopback() const {
  if (!tcp || host == "localhost") return true;
  const auto address = socket_address(host, port);
  return address && address->is_loopback();
}

Endpoint parse_endpoint(const std::string& text) {
  Endpoint endpoint;
  if (text.starts_with("ipc://")) {
    endpoint.path = text.substr(6);
    if (endpoint.path.empty()) malformed(text, " without a path");
    if (endpoint.path.size() > kMaxPath) {
      malformed(text, fmt::format(" has a path longer than {} bytes", kMaxPath).c_str());
    }
    return endpoint;
  }
  if (!text.starts_with("tcp://")) malformed(text, "");
  endpoint.tcp = true;
  const std::string address = text.substr(6);
  const size_t colon = address.rfind(':');
  if (colon == std::string::npos || colon == 0) malformed(text, " without a port");
  endpoint.host = address.substr(0, colon);
  const std::string port = address.substr(colon + 1);
  if (endpoint.host.find_first_of(" /;") != std::string::npos) malformed(text, "");
  if (port == "*") return endpoint;
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), endpoint.port);
  if (error != std::errc() || end != port.data() + port.size() || endpoint.port < 0 ||
      endpoint.port > 65535) {
    malformed(text, fmt::format(" has the port '{}'", port).c_str());
  }
  return endpoint;
}

}  // namespace tessera
