#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace tessera {

/// Where in a text a thing was found. Lines and columns count from 1; 0 means not known.
struct SourcePlace {
  std::string file;
  int line = 0;
  int column = 0;
  /// "file:line:column", leaving out what is not known.
  std::string str() const;
};

/// The process exit codes of the command-line contract.
enum class ExitCode {
  done = 0,
  bad_scene = 1,
  bad_usage = 2,
  render_failed = 3,
  interrupted = 4,
  /// EX_TEMPFAIL of sysexits.h: nothing is wrong with what was asked for, and the same command does
  /// it once a condition has passed, such as a full disk or a locked file.
  try_again = 75,
};

/// The code of that number, as a message has it; render_failed where there is none.
ExitCode to_exit_code(uint32_t number);

/// What the user has to know of a failure that is not our own bug: thrown where it is found, told
/// in the command line. Between them it is caught only to add the place that the thrower did not
/// know, or where one job or worker fails and others go on. Messages read "place: what was found;
/// what was expected".
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

/// The scene, or a file that it names, is wrong (exit code 1).
Error scene_error(const SourcePlace& place, std::string_view found, std::string_view expected);
Error scene_error(std::string_view message);
/// The command line is wrong (exit code 2).
Error usage_error(std::string_view message);
/// Rendering or writing failed (exit code 3).
Error render_error(std::string_view message);
/// A resource has run out or is taken; the same may succeed later (exit code 75).
Error temporary_error(std::string_view message);
/// Whether `error`, a value of errno, says that something has run out, is taken or cannot be
/// reached now, so that the same call may succeed later. Says nothing about the data themselves.
bool is_temporary(int error);

/// The candidate nearest to `name` by edit distance, if near enough to be a likely slip of the pen;
/// else the first that it may be short for, or that is short for it: 'sobol' for 'owen-sobol'.
std::optional<std::string> nearest_name(std::string_view name,
                                        std::span<const std::string> candidates);

/// "; did you mean 'x'?" for the nearest candidate, or an empty string.
std::string suggestion(std::string_view name, std::span<const std::string> candidates);

/// A promise of our own code; when broken it prints both values and aborts.
[[noreturn]] void check_failed(const char* file, int line, const char* condition,
                               const std::string& values);

}  // namespace tessera

#define TESSERA_CHECK(condition, ...)                                       \
  do {                                                                      \
    if (!(condition)) [[unlikely]]                                          \
      ::tessera::check_failed(__FILE__, __LINE__, #condition, __VA_ARGS__); \
  } while (false)
