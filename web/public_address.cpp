#include "web/public_address.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdint>

#include "base/error.h"
#include "base/lower_case.h"

namespace tessera {

std::string host_of(const std::string& authority) {
  const size_t end = authority.starts_with('[') ? authority.find(']') + 1 : authority.find(':');
  const std::string host = authority.substr(0, end), port = authority.substr(host.size());
  if (port.empty()) return host;
  uint16_t number = 0;
  const char* const port_end = port.data() + port.size();
  const auto [stop, problem] = std::from_chars(port.data() + 1, port_end, number);
  return port.front() == ':' && problem == std::errc() && stop == port_end ? host : std::string();
}

bool names_this_machine(const std::string& host) {
  const bool digits =
      host.starts_with("127.") && host.find_first_not_of("0123456789.") == std::string::npos;
  return digits || host == "localhost" || host == "[::1]";
}

PublicAddress parse_public_address(std::string_view option, const std::string& text) {
  const size_t scheme_end = text.find("://");
  const std::string scheme =
      scheme_end == std::string::npos ? "" : lower_case(text.substr(0, scheme_end));
  const size_t begin = scheme_end == std::string::npos ? text.size() : scheme_end + 3;
  const size_t path_at = std::min(text.find('/', begin), text.size());
  std::string authority = lower_case(text.substr(begin, path_at - begin));
  std::string path = text.substr(path_at);
  const std::string host = host_of(authority);
  constexpr std::string_view kInHosts = "abcdefghijklmnopqrstuvwxyz0123456789.-_[]:";
  if ((scheme != "http" && scheme != "https") || host.empty() ||
      authority.find_first_not_of(kInHosts) != std::string::npos ||
      path.find_first_of("?# \\") != std::string::npos) {
    throw usage_error(
        fmt::format("{}: '{}'; expected the address by which browsers reach the page, such as "
                    "https://farm.example/tessera/",
                    option, text));
  }
  // Browsers leave out the port that the scheme has anyway.
  const std::string usual = scheme == "https" ? ":443" : ":80";
  if (authority.substr(host.size()) == usual) authority = host;
  if (!path.ends_with('/')) path += '/';
  std::string origin = scheme + "://" + authority;
  return {.url = origin + path, .origin = origin, .host = host};
}

}  // namespace tessera
