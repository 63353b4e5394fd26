#pragma once

#include <cstdint>

#include "coordinator/jobs/farm_snapshot.h"
#include "proto/tessera/v1/scene.pb.h"
#include "renderer/film/film.h"

namespace tessera {

/// The film so far, its light averaged over squares so that no side is longer than `most_side`
/// (above 0), then made numbers as `output` says.
PreviewImage make_preview(const Film& film, const v1::Output& output, uint64_t tiles_done,
                          int most_side);

/// The light of a film, without what is beside it: a copy.
Film light_of(const FilmView& film);

}  // namespace tessera
