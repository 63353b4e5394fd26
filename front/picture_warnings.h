#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "front/render_options.h"
#include "job/job.h"
#include "renderer/film/film.h"
#include "renderer/film/tone_map.h"
#include "scenes/import/loaded_scene.h"

namespace tessera {

/// What of the pictures asked for will hardly be what was meant: all of them black, or all the
/// same, surfaces that send back more light than they get, lights that take some away.
std::vector<std::string> picture_warnings(const RenderOptions& options, const LoadedScene& loaded);
/// Those, after what was told of reading the scene: each once.
std::vector<std::string> scene_warnings(const RenderOptions& options, const LoadedScene& loaded);
/// What a report does not say of its picture.
struct PictureOrigin {
  std::string scene{};         ///< its file; empty: not known
  bool is_of_strokes = false;  ///< has_strokes_alone() of the scene
  bool is_whole = true;        ///< shows_whole_frame()
};
/// Whether a picture is no crop of its frame.
bool shows_whole_frame(const Film& film, const v1::FrameSettings& frame);
/// What of a picture that was traced is hardly what was meant: what its scene leaves out, samples
/// that were no colour, or nothing but the background in all of the frame.
std::vector<std::string> report_warnings(const JobReport& report, const PictureOrigin& origin = {});
/// Whether all shapes are drawn points and lines, which importers let cast no shadow.
bool has_strokes_alone(const v1::Scene& scene);
/// As mesh_warnings() of what was built of that file.
std::vector<std::string> located_mesh_warnings(const CounterMap& counters,
                                               const std::string& scene);
/// That much of a picture of light is brighter than white, where a file of integers is among
/// `paths` and its tone curve just cuts that off, and by how much less light it would show.
/// `settings`: of such files.
std::vector<std::string> brightness_warnings(const v1::FrameSettings& frame,
                                             std::span<const std::filesystem::path> paths,
                                             const Film& film, const OutputSettings& settings);
/// What the files that they go to will not hold.
std::vector<std::string> file_warnings(const RenderOptions& options, const LoadedScene& loaded);

}  // namespace tessera
