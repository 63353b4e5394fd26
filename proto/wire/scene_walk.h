#pragma once

#include <google/protobuf/text_format.h>

#include <optional>
#include <string>

#include "proto/tessera/v1/scene.pb.h"

namespace tessera {

/// What no scene may hold, and where it was written, if that is known.
struct SceneFault {
  std::string found, expected;
  std::string path;  ///< "cameras[0].lens.radius_x"
  int line = 0, column = 0;
};

/// The first number in `scene` that is infinite or not a number, number of an enumeration that has
/// no such value, or message more than kMaxSceneDepth deep. `places` may be null.
std::optional<SceneFault> find_fault(const v1::Scene& scene,
                                     google::protobuf::TextFormat::ParseInfoTree* places);

}  // namespace tessera
