#pragma once

#include <google/protobuf/descriptor.h>

#include <string>

namespace tessera {

/// The text with the values of enumerations as Python has them: "phong" for PHONG.
std::string with_python_words(const std::string& text,
                              const google::protobuf::FileDescriptor& file);

}  // namespace tessera
