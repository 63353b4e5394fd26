#pragma once

#include <string>
#include <string_view>

namespace tessera {

/// The address by which browsers reach a page through a proxy, which may speak TLS and serve it
/// below a path: "https://farm.example/tessera/". Hosts and schemes are in lower case.
struct PublicAddress {
  std::string url;     ///< ends in "/"
  std::string origin;  ///< as browsers send it: scheme, host, and a port that is not the scheme's
  std::string host;    ///< without port; IPv6 in brackets
};

/// Throws usage_error, which names the option, for what is no http or https URL of a page.
PublicAddress parse_public_address(std::string_view option, const std::string& text);

/// The host of "name" or "name:port", the name perhaps an address in brackets; empty where it is
/// neither.
std::string host_of(const std::string& authority);
/// Whether the host, in lower case, is one of this machine's own names: localhost, 127.x.y.z,
/// [::1].
bool names_this_machine(const std::string& host);

}  // namespace tessera
