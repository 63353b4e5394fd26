#pragma once

#include <string>

#include "coordinator/jobs/farm_snapshot.h"

namespace tessera {

/// The image as a PNG file, compressed for speed. Throws render_error where there is no memory.
std::string png_file(const PreviewImage& image);

}  // namespace tessera
