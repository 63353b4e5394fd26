#pragma once

#include <string>
#include <string_view>

namespace tessera {

/// Why `name` cannot be that of a file below a folder; empty where it can: a relative path in UTF-8
/// with '/'; no part is empty, longer than 255 bytes or begins with '.' (which "..", too,
/// does).
std::string fault_of_name(std::string_view name);

}  // namespace tessera
