#include "proto/transport/endpoint.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <net/if.h>

#include <array>
#include <charconv>
#include <cstdint>

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

bool is_interface_index(const std::string& zone) {
  uint32_t index = 0;
  const auto [end, error] = std::from_chars(zone.data(), zone.data() + zone.size(), index);
  std::array<char, IF_NAMESIZE> name{};
  return error == std::errc() && end == zone.data() + zone.size() &&
         if_indextoname(index, name.data()) != nullptr;
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

void check_zone(const Endpoint& endpoint) {
  const std::string text = endpoint.str();
  const std::string& host = endpoint.host;
  const bool has_brackets = host.starts_with("[") && host.ends_with("]");
  const std::string address = has_brackets ? host.substr(1, host.size() - 2) : host;
  const size_t percent = address.find('%');
  in6_addr digits{};
  if (inet_pton(AF_INET6, address.substr(0, percent).c_str(), &digits) != 1) return;
  const bool is_local = IN6_IS_ADDR_LINKLOCAL(&digits);
  if (percent == std::string::npos) {
    if (!is_local) return;
    throw usage_error(fmt::format(
        "endpoint '{}' has a link-local address; expected its network interface after it, such as "
        "[{}%eth0]",
        text, address));
  }
  const std::string zone = address.substr(percent + 1);
  if (!is_local) {
    throw usage_error(fmt::format(
        "endpoint '{}' has the zone '{}'; expected none but for a link-local address (fe80::)",
        text, zone));
  }
  if (if_nametoindex(zone.c_str()) != 0 || is_interface_index(zone)) return;
  throw usage_error(fmt::format(
      "endpoint '{}' has the zone '{}'; expected a network interface of this machine", text, zone));
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
