#pragma once

#include <cstdlib>
#include <string>

namespace tessera {

/// The folder of the project's sources, without a slash at its end. ctest tells it by the
/// environment, so that no binary depends on where it was compiled; by hand, run tests from that
/// folder.
inline std::string source_folder() {
  const char* told = std::getenv("TESSERA_SOURCE_FOLDER");
  return told ? told : ".";
}

}  // namespace tessera
