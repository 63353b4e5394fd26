#pragma once

#include <string>
#include <vector>

#include "bench/error/curve.h"

namespace tessera {

/// The kinds of text that `tessera bench error` writes.

/// The heads of the columns, and one scene's rows under them, its slopes and its peers.
std::string error_table(const SceneErrors& scene);
/// {"rows": [...], "curves": [...], "peers": [...]}: rows have at least scene, method, samples,
/// seconds, rmse and bias.
std::string error_json(const std::vector<SceneErrors>& scenes);
/// The rows alone, comma-separated, under a line of names.
std::string error_csv(const std::vector<SceneErrors>& scenes);
/// Seconds a megapixel until the RMSE is 1/64 and 1/256 for each scene and method, as Markdown.
std::string error_summary(const std::vector<SceneErrors>& scenes);
/// Time against error, with bands, slopes to compare with and the reference's own error.
std::string error_svg(const SceneErrors& scene);
/// Time against 1/(MSE * time): level where the error falls as that of independent samples.
std::string efficiency_svg(const SceneErrors& scene);

}  // namespace tessera
