#pragma once

#include <optional>
#include <string>

#include "image/image_file.h"
#include "job/job.h"
#include "proto/tessera/v1/scene.pb.h"
#include "renderer/film/film.h"

namespace tessera {

/// A finished picture, or what was done of one: the film and what files and statistics tell of it.
/// Nobody changes one that was handed out.
struct RenderedPicture {
  Film film;
  v1::Output output;  ///< what the scene asks of its numbers
  ImageMetadata metadata{};
  JobReport report{};
  std::string statistics{};               ///< as `--stats` writes; empty: of no render
  std::optional<double> auto_exposure{};  ///< stops; chosen where it was asked for
};

}  // namespace tessera
