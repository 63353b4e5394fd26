#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "studio/files/folder.h"
#include "studio/files/templates.h"

namespace tessera {

/// A scene without a title that places the model, whose path is below the opened folder, before a
/// camera that sees all of it.
std::vector<TemplateFile> scene_of_model(const std::string& model);

/// Whether the file is geometry alone, which is seen once a scene places it: .obj, .ply, .stl,
/// .glb.
bool is_bare_model(std::string_view file);

/// What is opened where that file is asked for: a scene that places it, where it is a model by
/// itself. One that was made so before is taken again while it is as it was made.
std::string scene_to_open(const Folder& folder, const std::string& file);

/// The files of that template; none where there is no such template.
std::vector<TemplateFile> scene_of_template(const std::string& id);

}  // namespace tessera
