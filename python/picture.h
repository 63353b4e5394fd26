#pragma once

#include <memory>

#include "front/frame_task.h"
#include "python/array.h"

namespace tessera {

/// The light or one other channel group of a picture as an array (h, w) or (h, w, 3), without a
/// copy where it lies in one piece. Throws usage_error for a name that the picture has not.
Array channels_of(const std::shared_ptr<RenderedPicture>& picture, const std::string& name);

}  // namespace tessera
