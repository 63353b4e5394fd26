#pragma once

#include <gtest/gtest.h>

#include <string>

#include "base/error.h"

namespace tessera {

/// The message of the Error, of that code, that `action` throws; "no error" where it throws none.
template <typename Action>
std::string error_of(const Action& action, ExitCode code = ExitCode::bad_scene) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code);
    return error.what();
  }
  return "no error";
}

/// The same of an error in what the user typed.
template <typename Action>
std::string usage_error_of(const Action& action) {
  return error_of(action, ExitCode::bad_usage);
}

}  // namespace tessera
