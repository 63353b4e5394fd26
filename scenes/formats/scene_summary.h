#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "proto/tessera/v1/scene.pb.h"
#include "proto/wire/blob_store.h"

namespace tessera {

/// What a scene holds and what of it no picture can show.
struct SceneSummary {
  struct Count {
    std::string what;  ///< "triangles", "point lights" ...
    uint64_t count = 0;
  };
  std::vector<Count> counts;           ///< what is there, in a fixed order; nothing with count 0
  std::vector<std::string> unused;     ///< "material 'red'" ...: defined, but never referred to
  std::vector<std::string> undefined;  ///< "material 'rde'; did you mean 'red'?": the reverse
};

SceneSummary summarize(const v1::Scene& scene, const BlobStore& blobs);

}  // namespace tessera
