#include "cli/bench/timed_process.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/wait.h>

#include <chrono>

#include "base/error.h"
#include "base/process.h"

namespace tessera {

double timed_process(const std::vector<std::string>& arguments) {
  const auto start = std::chrono::steady_clock::now();
  const int status =
      wait_for_process(start_process(arguments[0], arguments, {.discards_output = true}));
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw render_error(
        fmt::format("{}: ended with {}", fmt::join(arguments, " "), how_it_ended(status)));
  }
  return taken.count();
}

}  // namespace tessera
