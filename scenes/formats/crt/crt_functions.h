#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/formats/crt/crt_value.h"
#include "scenes/formats/crt/java_random.h"

namespace tessera {

/// The functions that come with the language; `rand` runs through one sequence a script.
class CrtFunctions {
 public:
  static bool has(std::string_view name);
  static std::vector<std::string> names();
  /// Throws CrtError at `where` for a wrong number or type of arguments. `name` must be known.
  CrtValue call(std::string_view name, std::span<const CrtValue> arguments, CrtSpan where);

 private:
  JavaRandom random_{1337};
};

}  // namespace tessera
