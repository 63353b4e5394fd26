#pragma once

#include <optional>
#include <string>
#include <vector>

#include "front/option_list.h"
#include "proto/tessera/v1/scene.pb.h"
#include "renderer/film/tone_map.h"

namespace tessera {

/// What the command line asks of the picture's numbers; what is absent comes from the scene. The
/// names are among those below.
struct OutputOptions {
  std::optional<std::string> tone_map{}, transfer{};
  std::optional<double> gamma{};     ///< > 0; asks for the gamma curve too
  std::optional<double> exposure{};  ///< stops
  bool auto_exposure = false;        ///< it is chosen from the finished picture
  int bits = 8;                      ///< of a channel: 8 or 16
  /// OpenColorIO in place of tone map and transfer curve. The view may be "default".
  std::optional<std::string> ocio_view{}, ocio_display{}, ocio_space{}, ocio_input{};
};

const std::vector<std::string>& tone_map_names();
const std::vector<std::string>& transfer_names();

/// The options of these. Formats of floats hold the linear picture whatever they say.
void add_output_options(OptionList& list, OutputOptions& options);

/// What the scene asks, with the options laid over it. Throws usage_error for a gamma beside
/// another transfer curve.
v1::Output with_options(v1::Output of_scene, const OutputOptions& options);
/// What the numbers of a linear picture stand for, as its metadata tell.
const char* colors_of(const v1::Output& of_scene);
/// What the scene in that file asks of its picture, with the options laid over it. Throws
/// scene_error for numbers of the scene out of their range.
OutputSettings output_settings(const std::string& scene_file, const v1::Output& of_scene,
                               const OutputOptions& options = {});

}  // namespace tessera
