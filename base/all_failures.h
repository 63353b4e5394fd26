#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"

namespace tessera {

/// As many faults of one text are told at once.
inline constexpr size_t kMostFaults = 20;

/// Does several things whatever becomes of each, and then tells all that failed, or the first
/// `most` of them and that there are more.
class AllFailures {
 public:
  explicit AllFailures(size_t most = std::numeric_limits<size_t>::max()) : most_(most) {}

  template <typename Work>
  void attempt(const Work& work) {
    try {
      work();
    } catch (const Error& error) {
      add(error);
    }
  }
  void add(const Error& error) {
    const std::string message = error.what();
    const bool is_known = std::any_of(errors_.begin(), errors_.end(),
                                      [&](const Error& known) { return known.what() == message; });
    if (is_known) return;
    has_more_ = errors_.size() == most_;
    if (!has_more_) errors_.push_back(error);
  }
  /// Whether there were more than are told.
  bool has_more() const { return has_more_; }

  /// A line each, with the exit code of the first; none where nothing failed.
  std::optional<Error> error() const {
    if (errors_.empty()) return std::nullopt;
    std::string message;
    std::vector<Diagnostic> diagnostics;
    for (const Error& error : errors_) {
      if (!message.empty()) message += '\n';
      message += error.what();
      diagnostics.insert(diagnostics.end(), error.diagnostics().begin(), error.diagnostics().end());
    }
    if (has_more_) message += "\n" + std::to_string(most_) + " errors; the rest is not told";
    return Error(errors_.front().code(), message, std::move(diagnostics));
  }
  void throw_if_any() const {
    if (const auto all = error()) throw *all;
  }

 private:
  size_t most_;
  std::vector<Error> errors_;
  bool has_more_ = false;
};

}  // namespace tessera
