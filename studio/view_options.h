#pragma once

#include <string>
#include <utility>
#include <vector>

#include "front/option_list.h"
#include "front/render_options.h"
#include "renderer/film/tone_map.h"
#include "studio/page_message.h"

namespace tessera {

/// What `tessera render` would be asked for to get that view's picture: the wish over the scene.
/// Throws usage_error for an override that is none of its options, or whose value is wrong.
RenderOptions view_options(const page::View& wish, const std::string& scene_path);

/// How the scene's light becomes numbers there. Throws as view_options().
OutputSettings view_output(const page::View& wish, const std::string& scene_path,
                           const v1::Output& of_scene);

/// Assigns options by their long names, flags where they are "true". Throws usage_error for one
/// that is not in the list, or whose value is wrong.
void assign_options(const OptionList& list,
                    const std::vector<std::pair<std::string, std::string>>& given);

/// Takes --denoise out of them, which is none of the options that say what to trace.
void take_denoise(std::vector<std::pair<std::string, std::string>>& given, RenderOptions& options);

/// All of the wish that decides pixels beside the scene, size and samples, as a text to compare.
/// `has_aovs`: films have values beside light.
std::string view_settings(const page::View& wish, bool has_aovs);

}  // namespace tessera
