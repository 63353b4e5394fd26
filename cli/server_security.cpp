#include "cli/server_security.h"

#include <fmt/format.h>
#include <unistd.h>

#include <array>

#include "base/error.h"
#include "base/log.h"
#include "front/farm_connection.h"
#include "proto/transport/endpoint.h"

namespace tessera {
namespace {

/// The endpoint by which others reach a socket that listens at every address of this machine.
std::string reachable(const std::string& text) {
  Endpoint endpoint = parse_endpoint(text);
  if (!endpoint.tcp ||
      (endpoint.host != "0.0.0.0" && endpoint.host != "[::]" && endpoint.host != "*"))
    return text;
  std::array<char, 256> name{};
  if (gethostname(name.data(), name.size() - 1) != 0) return text;
  endpoint.host = name.data();
  return endpoint.str();
}

}  // namespace

ServerSecurity read_security(const SecurityOptions& options) {
  ServerSecurity security;
  security.insecure = options.insecure;
  if (options.key.empty() != options.allow.empty()) {
    throw usage_error(options.key.empty()
                          ? "--allow: needs --key, the coordinator's secret key, beside it"
                          : "--key: needs --allow, the list of keys that are let in, beside it");
  }
  if (options.key.empty()) return security;
  if (options.insecure) throw usage_error("--insecure: is for no keys; expected no --key");
  security.keys = read_secret_key(options.key, "--key");
  security.allowed = read_allow_list(options.allow, "--allow");
  if (security.allowed.size() == 0)
    spdlog::warn("--allow: '{}' lists no key: nobody is let in", options.allow);
  return security;
}

std::string worker_command(const std::string& endpoint, const ServerSecurity& security) {
  std::string command = "tessera worker --connect " + reachable(endpoint);
  if (security.keys)
    command +=
        fmt::format(" --key worker.key --server-key {}", key_text(security.keys->public_key));
  return command;
}

}  // namespace tessera
