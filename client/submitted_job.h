#pragma once

#include <cstdint>

#include "job/job.h"
#include "proto/tessera/v1/farm.pb.h"
#include "proto/wire/blob_store.h"

namespace tessera {

/// A job as its client hands it over: the request, and all blobs that the coordinator may ask for.
struct SubmittedJob {
  v1::SubmitJob request;
  BlobStore blobs;
};

/// A number for SubmitJob.submission, drawn at random.
uint64_t draw_submission();

/// Adds a frame of that scene, whose window and tile size are those of the whole job.
void add_frame(SubmittedJob& job, const JobSpec& frame, int number = 0,
               const v1::Output& output = {});

}  // namespace tessera
