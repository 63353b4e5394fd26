#include "front/farm_connection.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include "base/error.h"
#include "base/file.h"
#include "proto/transport/endpoint.h"

namespace tessera {
namespace {

constexpr uint64_t kLongestKeyFile = 4 << 20;
constexpr uint64_t kLongestAllowList = 16 << 20;

/// Keys are no scenes: what is wrong with them is wrong with the command line.
std::string read_file(const std::string& path, const std::string& option, uint64_t most) {
  try {
    return read_input_file(path, most);
  } catch (const Error& error) {
    throw usage_error(fmt::format("{}: {}", option, error.what()));
  }
}

}  // namespace

std::string read_secret_file(const std::string& path, const std::string& option) {
  std::string text = read_file(path, option, kLongestKeyFile);
  struct stat status {};
  if (stat(path.c_str(), &status) == 0 && (status.st_mode & S_IRWXO) != 0) {
    throw usage_error(fmt::format("{}: '{}' has mode {:04o}: every user can read it; expected 0600",
                                  option, path, status.st_mode & 07777));
  }
  return text;
}

KeyPair read_secret_key(const std::string& path, const std::string& option) {
  return parse_secret_key_file(read_secret_file(path, option), path);
}

Key read_public_key(const std::string& text, const std::string& option) {
  if (const auto key = parse_key(text)) return *key;
  const std::string content = read_file(text, option, kLongestKeyFile);
  const size_t end = std::min(content.find_first_of(" \t\r\n"), content.size());
  if (const auto key = parse_key(std::string_view(content).substr(0, end))) return *key;
  throw usage_error(
      fmt::format("{}: '{}' holds no public key; expected 64 digits 0-9 a-f, or the .pub file that "
                  "'tessera keygen' wrote",
                  option, text));
}

std::string read_allow_text(const std::string& path, const std::string& option) {
  struct stat status {};
  // Nobody at all may be let in, yet.
  if (stat(path.c_str(), &status) == 0 && S_ISREG(status.st_mode) && status.st_size == 0) return {};
  return read_file(path, option, kLongestAllowList);
}

AllowList read_allow_list(const std::string& path, const std::string& option) {
  return AllowList::parse(read_allow_text(path, option), path);
}

void add_connection_options(OptionList& list, FarmConnection& connection,
                            const std::string& group_name) {
  OptionGroup group(list, group_name);
  group.add("--connect", "ENDPOINT",
            "The coordinator of a running 'tessera serve', tcp://HOST:PORT or ipc://PATH" +
                (connection.endpoint.empty() ? "" : fmt::format(" [{}]", connection.endpoint)),
            [&connection](const std::string& text) {
              parse_endpoint(text);  // an empty text would be no coordinator at all
              connection.endpoint = text;
            });
  group.add_text("--key", "FILE",
                 "Our secret key, as 'tessera keygen' wrote it: where the coordinator asks for one",
                 connection.key_file);
  group.add_text("--server-key", "FILE|KEY",
                 "The coordinator's public key: its .pub file, or the 64 digits themselves",
                 connection.server_key);
}

std::unique_ptr<ClientTransport> connect(const FarmConnection& connection) {
  if (connection.key_file.empty() != connection.server_key.empty()) {
    throw usage_error(connection.key_file.empty()
                          ? "--server-key: needs --key, our own secret key, beside it"
                          : "--key: needs --server-key, the coordinator's public key, beside it");
  }
  if (connection.key_file.empty()) return connect_client(connection.endpoint);
  const ClientKeys keys{read_secret_key(connection.key_file, "--key"),
                        read_public_key(connection.server_key, "--server-key")};
  return connect_client(connection.endpoint, keys);
}

}  // namespace tessera
