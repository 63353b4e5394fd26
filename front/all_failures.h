#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"

namespace tessera {

/// Does several things whatever becomes of each, and then tells all that failed.
class AllFailures {
 public:
  template <typename Work>
  void attempt(const Work& work) {
    try {
      work();
    } catch (const Error& error) {
      const std::string message = error.what();
      const bool is_known = std::any_of(errors_.begin(), errors_.end(), [&](const Error& known) {
        return known.what() == message;
      });
      if (!is_known) errors_.push_back(error);
    }
  }

  /// A line each, with the exit code of the first; none where nothing failed.
  std::optional<Error> error() const {
    if (errors_.empty()) return std::nullopt;
    std::string message;
    for (const Error& error : errors_)
      message += (message.empty() ? "" : "\n") + std::string(error.what());
    return Error(errors_.front().code(), message);
  }
  void throw_if_any() const {
    if (const auto all = error()) throw *all;
  }

 private:
  std::vector<Error> errors_;
};

}  // namespace tessera
