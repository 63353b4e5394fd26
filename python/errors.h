#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <utility>
#include <vector>

namespace tessera {

/// "a list", "an int", for messages.
std::string with_article(const std::string& noun);

/// The class of that name in `tessera.errors`, such as "SceneError".
pybind11::object error_class(const char* name);

/// Raises `tessera.errors.NAME(message, **keywords)`. The texts may be any bytes.
void set_python_error(const char* name, const std::string& message,
                      const std::vector<std::pair<const char*, std::string>>& keywords = {});

/// Throws a UsageError in place of Python's OverflowError, if that is raised: a whole number that
/// is too large for a float was given as `name`.
void refuse_overflow(const std::string& name);

/// Makes `tessera.errors.NAME(message)`, for `throw`.
pybind11::error_already_set python_error(const char* name, const std::string& message);

}  // namespace tessera
