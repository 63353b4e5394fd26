#pragma once

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "base/plain_text.h"
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

/// On standard error, and it may hold what a file says: for a terminal, made printable but for its
/// line ends.
inline void say_error(std::string_view message) {
  constexpr size_t kLongest = 10'000;  // room for two paths
  std::string shown;
  for (size_t at = 0; at <= message.size() && shown.size() < kLongest;) {
    const std::string_view line = message.substr(at, message.find('\n', at) - at);
    shown += printable(line, kLongest - shown.size()) + "\n";
    at += line.size() + 1;
  }
  say(stderr, "tessera: {}", shown);
}
/// One line.
inline void say_warning(std::string_view message) {
  say_error(escape_controls(fmt::format("warning: {}", message)));
}
/// Says each warning once, whatever numbers are in it; of an animation, with the first frame that
/// it is said of.
class WarningsOnce {
 public:
  void say(const std::string& message, std::optional<int> frame = std::nullopt) {
    std::string words = message;
    std::erase_if(words, [](char c) { return ('0' <= c && c <= '9') || c == '.' || c == '-'; });
    if (!said_.insert(std::move(words)).second) return;
    say_warning(frame ? fmt::format("frame {}: {}", *frame, message) : message);
  }

 private:
  std::set<std::string> said_;
};

}  // namespace tessera
