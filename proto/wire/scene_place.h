#pragma once

#include <google/protobuf/text_format.h>

#include <optional>
#include <string>
#include <string_view>

#include "base/error.h"
#include "proto/tessera/v1/scene.pb.h"

namespace tessera {

// Paths lead from the scene to a field of it, in the names of scene.proto: "nodes[3].shape.sphere".

/// The path of what `message`, an error of building `scene`, begins with: "node 'hall' > node 3 >
/// shape: sphere.radius is ...". Nothing where the scene has no such part, or several.
std::optional<std::string> path_of_error(const v1::Scene& scene, std::string_view message);

/// Where `text`, whose `places` its parser told, writes the field of `path`, or else the innermost
/// of those around it.
SourcePlace place_in_text(const std::string& file, std::string_view text, std::string_view path,
                          const google::protobuf::TextFormat::ParseInfoTree& places);

/// The same where `text` is JSON that passed check_scene_json().
SourcePlace place_in_json(const std::string& file, std::string_view text, const std::string& path);

}  // namespace tessera
