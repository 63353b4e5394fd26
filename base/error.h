#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tessera {

/// Where in a text a thing was found. Lines and columns count from 1; 0 means not known.
struct SourcePlace {
  std::string file;
  int line = 0;
  int column = 0;
  /// "file:line:column", leaving out what is not known.
  std::string str() const;
};

/// What is wrong at one place, in the parts that a message is made of. Columns count bytes.
struct Diagnostic {
  SourcePlace place;         ///< of an empty file: not known
  SourcePlace end{};         ///< just behind what is meant, in the same file; line 0: not known
  std::string found;         ///< or the whole message, where it has no parts
  std::string expected{};    ///< without the suggestion
  std::string suggestion{};  ///< what may have been meant: the name alone; empty: nothing is near
};
/// The parts of what scene_error(place, found, expected) says, where either may end in what
/// suggestion() gives, and `found` may have "; expected " in it.
Diagnostic make_diagnostic(SourcePlace place, std::string_view found, std::string_view expected);
/// The place behind the word, number, quoted text or else single character at `place` of `text`;
/// line 0 where `text` has no such place.
SourcePlace end_of_word(std::string_view text, const SourcePlace& place);

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
  Error(ExitCode code, const std::string& message, std::vector<Diagnostic> diagnostics = {})
      : std::runtime_error(message),
        code_(code),
        diagnostics_(std::make_shared<const std::vector<Diagnostic>>(std::move(diagnostics))) {}
  ExitCode code() const { return code_; }
  /// What the message says of places, in its order; empty where it names none.
  const std::vector<Diagnostic>& diagnostics() const { return *diagnostics_; }

 private:
  ExitCode code_;
  std::shared_ptr<const std::vector<Diagnostic>> diagnostics_;  ///< so that copying throws nothing
};

/// The scene, or a file that it names, is wrong (exit code 1).
Error scene_error(const SourcePlace& place, std::string_view found, std::string_view expected);
Error scene_error(std::string_view message, std::vector<Diagnostic> diagnostics = {});
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
