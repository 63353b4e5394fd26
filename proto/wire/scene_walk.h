#pragma once

#include <google/protobuf/message.h>
#include <google/protobuf/text_format.h>

#include <optional>
#include <string>

namespace tessera {

/// A field of a message, and where it was written, if that is known.
struct FieldPlace {
  std::string path;  ///< "cameras[0].lens.radius_x"
  int line = 0, column = 0;
};

/// The first number in `message`, at any depth, that is infinite or not a number. `places` may be
/// null.
std::optional<FieldPlace> find_infinite(const google::protobuf::Message& message,
                                        google::protobuf::TextFormat::ParseInfoTree* places);

}  // namespace tessera
