#pragma once

#include <filesystem>
#include <string>

#include "base/error.h"

namespace tessera {

/// How a machine makes its own key known to a coordinator, as the command line says it.
struct EnrolOptions {
  std::filesystem::path key_file;  ///< to be made; the public key goes beside it
  std::string name;                ///< of the machine, as in a list of keys
  std::string tokens;              ///< a file of enrolment tokens
  std::string endpoint;
  std::string server_key;  ///< the coordinator's public key: a file, or its digits
};

/// Makes a key pair and has the coordinator take it up by the first token that is of use. The
/// secret key lies in KEY_FILE.new until the coordinator has answered, so that a command that was
/// ended in between goes on with that key; it has its own name only once it is let in. A key file
/// that is there already is left alone, and the result is done. Throws usage_error where no token
/// is of use, temporary_error where the coordinator cannot be reached or cannot keep the key now.
ExitCode enrol_key(const EnrolOptions& options);

/// Writes a file that was not there, durably, so that no key is ever lost to another. Throws
/// usage_error.
void write_new_file(const std::filesystem::path& path, const std::string& text, mode_t mode);

}  // namespace tessera
