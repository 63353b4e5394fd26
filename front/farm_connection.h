#pragma once

#include <memory>
#include <string>

#include "base/monotonic.h"
#include "front/option_list.h"
#include "proto/transport/zmq_transport.h"

namespace tessera {

/// How a command reaches a coordinator, as the command line says it.
struct FarmConnection {
  std::string endpoint;      ///< empty: not given
  std::string key_file{};    ///< our secret key; empty: none
  std::string server_key{};  ///< the coordinator's public key: a file, or its digits
  Time patience = std::chrono::seconds(15);  ///< with a coordinator that is silent
};

inline constexpr char kDefaultEndpoint[] = "tcp://127.0.0.1:7117";

/// --connect, --key and --server-key of any command that talks to a coordinator, in `group`;
/// `connection` must outlive the parsing. Its endpoint is the default; empty: there is none.
void add_connection_options(OptionList& list, FarmConnection& connection,
                            const std::string& group = "Options");
/// Reads the keys and begins to connect. Throws usage_error for a key that is missing or wrong.
std::unique_ptr<ClientTransport> connect(const FarmConnection& connection);

/// The text of the file of secret keys that `option` names. Throws usage_error where it cannot be
/// read, or can be read by everybody.
std::string read_secret_file(const std::string& path, const std::string& option);
/// The secret key in the file that `option` names. Throws usage_error where it cannot be read, is
/// no key, or can be read by everybody.
KeyPair read_secret_key(const std::string& path, const std::string& option);
/// The public key in a file that `tessera keygen` wrote, or that `text` spells.
Key read_public_key(const std::string& text, const std::string& option);
/// The text of a list of keys, which may be empty.
std::string read_allow_text(const std::string& path, const std::string& option);
AllowList read_allow_list(const std::string& path, const std::string& option);

}  // namespace tessera
