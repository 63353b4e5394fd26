#pragma once

#include <cstdint>
#include <string>

#include "bench/error/reference.h"
#include "bench/error_bench.h"

namespace tessera {

/// What one picture asks for beside its scene.
struct ErrorShot {
  uint32_t samples = 1, seed = 1;
  double target_error = 0;  ///< for adaptive methods
};

struct ErrorPicture {
  Picture picture;
  ErrorRun run;  ///< without its mse
  double mean_samples = 0;
  uint64_t not_finite = 0;
};

/// The scene as the method wants it.
v1::Scene with_method(v1::Scene scene, const ErrorMethod& method);

/// Renders on `threads` threads of this process, tile by tile as a worker does.
ErrorPicture render_shot(const v1::Scene& scene, const BlobStore& blobs, const ErrorMethod& method,
                         const ErrorShot& shot, int threads);

/// Two converged pictures of the scene by the integrator that it names itself, of `samples` each,
/// by Owen-scrambled points under two seeds that no benchmark uses; from `cache_folder` if it has
/// them of at least as many samples, at most `most_samples`. Tells how many they have.
Reference converged_reference(const v1::Scene& scene, const BlobStore& blobs, uint32_t& samples,
                              uint32_t most_samples, const std::string& cache_folder, int threads);

/// Red, green and blue of a picture in a file that read_image() reads. Throws a scene error where
/// it has none.
Picture read_picture(const std::string& path);

}  // namespace tessera
