#include "job/check_job.h"

#include <gtest/gtest.h>

#include "base/error.h"

namespace tessera {
namespace {

JobSpec job_of(int width, int height, AovSet aovs) {
  JobSpec spec;
  spec.frame.set_width(static_cast<uint32_t>(width));
  spec.frame.set_height(static_cast<uint32_t>(height));
  spec.frame.set_samples_per_pixel(1);
  spec.frame.set_aovs(aovs.bits());
  spec.crop = {0, 0, width, height};
  return spec;
}

TEST(CheckJob, aovs_must_fit_a_file_and_a_message) {
  EXPECT_NO_THROW(check_job(job_of(7680, 4320, AovSet::all())));
  EXPECT_NO_THROW(check_job(job_of(16384, 16384, {})));
  EXPECT_THROW(check_job(job_of(16384, 16384, AovSet::all())), Error);
  JobSpec wide = job_of(20000, 10, AovSet::all());
  EXPECT_NO_THROW(check_job(wide));
  wide.tile_size = 20000;
  EXPECT_THROW(check_job(wide), Error);
  wide.frame.set_aovs(0);
  EXPECT_NO_THROW(check_job(wide));
}

TEST(CheckJob, aovs_that_mean_nothing_are_refused) {
  JobSpec spec = job_of(8, 8, {});
  spec.frame.set_aovs(1u << 10);
  EXPECT_THROW(check_job(spec), Error);
}

}  // namespace
}  // namespace tessera
