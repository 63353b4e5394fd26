#pragma once

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <string>
#include <string_view>
#include <utility>

#include "proto/wire/printable.h"

namespace tessera {

/// Prints to `stream`. A reader that has gone or a full disk never ends the work, as an exception
/// of fmt::print would; main() looks whether standard output took everything.
template <typename... Values>
void say(std::FILE* stream, fmt::format_string<Values...> format, Values&&... values) {
  const std::string text = fmt::format(format, std::forward<Values>(values)...);
  std::fwrite(text.data(), 1, text.size(), stream);
}
template <typename... Values>
void say(fmt::format_string<Values...> format, Values&&... values) {
  say(stdout, format, std::forward<Values>(values)...);
}

/// Hands on what was said; the first error of standard output is what this returns ever after.
inline int flush_output() {
  static int error = 0;
  if (std::fflush(stdout) != 0 && error == 0) error = errno;
  return error;
}

/// One line on standard error that may hold what a file says: for a terminal, made printable.
inline void say_error(std::string_view message) {
  constexpr size_t kLongest = 10'000;  // room for two paths
  say(stderr, "tessera: {}\n", printable(message, kLongest));
}
inline void say_warning(std::string_view message) {
  say_error(fmt::format("warning: {}", message));
}

}  // namespace tessera
