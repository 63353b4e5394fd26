#pragma once

#include <string>

#include "proto/transport/zmq_transport.h"

namespace tessera {

/// Who may come to a coordinator, as a command line says it.
struct SecurityOptions {
  std::string key;        ///< the file of the coordinator's secret key; empty: no keys
  std::string allow;      ///< the file of the keys that are let in
  bool insecure = false;  ///< others than this machine are let in without keys
};

/// Reads the keys. Throws usage_error where one is missing beside the other or cannot be read.
ServerSecurity read_security(const SecurityOptions& options);

/// The command that has another machine, or this one, trace for a coordinator that listens there.
/// Its key is for whoever runs it to make; the public one of the coordinator is in the command.
std::string worker_command(const std::string& endpoint, const ServerSecurity& security);

}  // namespace tessera
