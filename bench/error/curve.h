#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bench/error/statistics.h"
#include "metrics/picture_error.h"

namespace tessera {

/// One picture of an estimator: what it cost and how far it was from the reference.
struct ErrorRun {
  double wall_seconds = 0, cpu_seconds = 0, build_seconds = 0;  ///< the first two are of tracing
  double mse = 0;                                               ///< mean_square_error()
};

/// A row of `tessera bench error`: a method with one number of samples, over all its seeds.
struct ErrorRow {
  double samples = 0;  ///< per pixel; adaptive methods: the mean
  int seeds = 0;
  double seconds = 0, cpu_seconds = 0, build_seconds = 0;  ///< medians of a picture
  double rmse = 0;                                         ///< of the mean of the seeds' MSE
  Band rmse_band;
  double bias = 0, bias_sigmas = 0;  ///< BiasEstimator::Result
  double efficiency = 0;             ///< 1 / (MSE * seconds)
  Band efficiency_band;
  /// The efficiency over that of the scene's first method with as many samples, seed by seed.
  std::optional<double> gain{};
  Band gain_band;
  PictureError error;       ///< means over the first seeds but for the greatest max_error
  uint64_t not_finite = 0;  ///< samples that were no finite colour, over all seeds
  std::vector<ErrorRun> runs;
};

/// How the error of one method in one scene falls.
struct ErrorCurve {
  std::string scene, method;
  std::vector<ErrorRow> rows;  ///< by rising samples
  double slope = 0;            ///< of log RMSE over log samples; 0 with fewer than three rows
  Band slope_band;
  std::string end{};  ///< why there are fewer rows than asked for; empty: there are not
};

/// A picture of another renderer.
struct PeerMark {
  std::string name;
  double seconds = 0, samples = 0;
  PictureError error;
  double rmse_scaled = 0;  ///< after its mean was made the reference's, whose noise cancels
};

/// What was found in one scene.
struct SceneErrors {
  std::string scene, about;
  std::string clock = "seconds a picture";  ///< what ErrorRow::seconds are
  int width = 0, height = 0;
  double reference_error = 0;  ///< 0: the reference has none that we know
  std::string reference;       ///< where it comes from, for readers
  std::vector<ErrorCurve> curves;
  std::vector<PeerMark> peers;
};

/// Medians, means and bands of a row's runs.
void summarize(ErrorRow& row);
/// The row's gain over `base`, by the seeds that both have.
void compare(ErrorRow& row, const ErrorRow& base);
/// Slope and band by the rows from four samples on, if those are three, else by all.
void fit_slope(ErrorCurve& curve);
/// Seconds until the RMSE is `target`, between rows on straight lines of logarithms: those of the
/// first row where that is below already; nothing where the curve does not come there.
std::optional<double> seconds_to(const ErrorCurve& curve, double target);

}  // namespace tessera
