#pragma once

#include <pybind11/pybind11.h>

#include <string>

namespace tessera {

/// "a list", "an int", for messages.
std::string with_article(const std::string& noun);

/// The class of that name in `tessera.errors`, such as "SceneError".
pybind11::object error_class(const char* name);

/// Makes `tessera.errors.NAME(message)`, for `throw`.
pybind11::error_already_set python_error(const char* name, const std::string& message);

}  // namespace tessera
