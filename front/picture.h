#pragma once

#include <optional>
#include <string>

#include "front/output_settings.h"
#include "front/render_options.h"
#include "front/rendered_picture.h"
#include "image/image_file.h"
#include "job/job.h"
#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Throws usage_error where the options do not go with the scene: a crop beyond the frame, or
/// denoising of what is no light or has one sample.
void check_picture_options(const RenderOptions& options, const v1::FrameSettings& settings);

/// The second of those alone.
void check_denoisable(const v1::FrameSettings& settings);

/// The job that traces a frame of the scene.
JobSpec picture_job(const RenderOptions& options, const LoadedScene& loaded,
                    const v1::FrameSettings& settings);

/// Whether the picture is denoised, where that was asked for. One with holes is left alone, and so
/// are passes of one sample.
bool is_denoised(bool is_asked_for, const JobReport& report, const v1::FrameSettings& settings);

/// From what was traced to what was asked for: denoises, and leaves out what only that looked at.
void finish_picture(const RenderOptions& options, const v1::FrameSettings& settings,
                    JobResult& result);

/// How the picture's numbers are shown: as its scene asks, with the options laid over that. Where
/// these leave the exposure to the picture and it has none, it is chosen from the film. Throws as
/// output_settings().
OutputSettings shown_settings(const std::string& scene_file, const RenderedPicture& picture,
                              const OutputOptions& options);

/// What the files of that picture tell of its making.
ImageMetadata picture_metadata(const v1::FrameSettings& settings, bool is_denoised,
                               const v1::Output& of_scene, const std::string& scene_digest);

}  // namespace tessera
