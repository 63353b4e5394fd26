#pragma once

#include "job/job.h"
#include "proto/tessera/v1/farm.pb.h"

namespace tessera {

/// A report as it travels to the client, without the film.
v1::JobEnd to_message(const JobReport& report);
JobReport from_message(const v1::JobEnd& end);

PixelRect rect_of(const v1::PixelRect& rect);
v1::PixelRect to_message(const PixelRect& rect);

}  // namespace tessera
