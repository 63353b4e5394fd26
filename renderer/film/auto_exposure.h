#pragma once

#include "renderer/film/film.h"

namespace tessera {

/// The exposure, in stops and hundredths of them, that brings the log-average luminance (Reinhard
/// et al. 2002, equation 1) of the film to middle grey, .18. It is that of the middle four fifths
/// of its pixels by luminance, so that neither lights nor deep shadows count; and of those that
/// show a surface alone, where the film tells: by alpha, depth or id. 0 where none has light.
double auto_exposure(const Film& film);

}  // namespace tessera
