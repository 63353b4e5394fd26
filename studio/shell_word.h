#pragma once

#include <string>

namespace tessera {

/// The text as one word of a shell's command line: in single quotes where the shell would take it
/// for anything but itself.
std::string shell_word(const std::string& text);

}  // namespace tessera
