#pragma once

#include "job/job.h"
#include "proto/tessera/v1/farm.pb.h"

namespace tessera {

/// A report as it travels to the client, without the film.
v1::JobEnd to_message(const JobReport& report);
JobReport from_message(const v1::JobEnd& end);

PixelRect rect_of(const v1::PixelRect& rect);
/// What is beside light in the pictures of a frame of the job, which has that many.
AovSet aovs_of(const v1::SubmitJob& request, uint32_t frame);
/// Of the picture of that frame.
uint64_t film_bytes_of(const v1::SubmitJob& request, uint32_t frame);
v1::PixelRect to_message(const PixelRect& rect);

}  // namespace tessera
