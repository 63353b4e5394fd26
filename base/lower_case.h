#pragma once

#include <string>

namespace tessera {

/// ASCII alone: names of formats, protocols and attributes, in any locale.
inline char lower_case(char c) { return 'A' <= c && c <= 'Z' ? static_cast<char>(c + 32) : c; }

inline std::string lower_case(std::string text) {
  for (char& c : text) c = lower_case(c);
  return text;
}

}  // namespace tessera
