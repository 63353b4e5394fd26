#pragma once

#include "renderer/film/film.h"

namespace tessera {

/// What denoise() looks at beside light: albedo, normal, depth and variance.
AovSet denoising_aovs();

/// What a picture's metadata call it.
inline constexpr char kDenoiserName[] = "joint non-local means";

/// Puts in place of each pixel's light a mean over like pixels about it: those whose surroundings
/// differ by no more than their variances explain (Rousselle, Knaus and Zwicker 2012, "Adaptive
/// Rendering with Non-Local Means Filtering", TOG 31(6), equation 4) and whose albedo, normal and
/// depth are alike (the same and Manzi 2013, "Robust Denoising using Feature and Color
/// Information", PGF 32(7), section 4). Biased: what varies less than the noise is smoothed away
/// with it; as variances fall with more samples, so does what it changes. The film must have
/// denoising_aovs(), which stay as they are. The same bits for any number of threads. Memory: some
/// 80 bytes a pixel. Whatever it throws, as where a Cancellation of the caller ends it, leaves the
/// film as it was.
void denoise(Film& film, int threads);

}  // namespace tessera
