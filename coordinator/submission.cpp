#include "coordinator/submission.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "base/saturating_sum.h"
#include "job/job.h"
#include "job/job_messages.h"
#include "proto/wire/scene_codec.h"
#include "renderer/film/aov.h"
#include "renderer/film/tile.h"

namespace tessera {
namespace {

/// At one go, so that workers do not wait for a long animation to be read.
constexpr uint64_t kReadBytes = uint64_t{4} << 20;
constexpr size_t kMaxBlobs = size_t{1} << 18;

/// Of the largest of its films, which are not all there at one time; 0 where the crop is none,
/// which is refused later.
uint64_t largest_film_bytes(const v1::SubmitJob& request) {
  const v1::PixelRect& crop = request.crop();
  const int64_t width = int64_t{crop.x1()} - crop.x0(), height = int64_t{crop.y1()} - crop.y0();
  if (width <= 0 || height <= 0 || width > kMaxFrameSide || height > kMaxFrameSide) return 0;
  uint64_t bytes = 0;
  for (int frame = 0; frame < request.frames_size(); ++frame) {
    bytes = std::max(bytes, film_bytes_of(request, static_cast<uint32_t>(frame)));
  }
  return bytes;
}

}  // namespace

Submission::Submission(v1::SubmitJob request, JobStore& store, Time now)
    : last_heard(now), request_(std::move(request)), fetch_(request_.submission()) {
  status.set_submission(request_.submission());
  status.set_state(v1::JobStatus::FETCHING);
  if (request_.submission() == 0) {
    throw usage_error("submission 0; expected a number that was drawn");
  }
  if (request_.priority() < -kMostPriority || request_.priority() > kMostPriority) {
    throw usage_error(fmt::format("a submission of priority {}; expected a number from {} to {}",
                                  request_.priority(), -kMostPriority, kMostPriority));
  }
  if (request_.name().size() > kMostName) {
    throw usage_error(fmt::format("a submission with a name of {} bytes; expected at most {}",
                                  request_.name().size(), kMostName));
  }
  claimed_bytes_ = largest_film_bytes(request_);
  for (const v1::JobFrame& frame : request_.frames()) {
    const auto digest = Digest::parse(frame.scene_digest());
    if (!digest) throw usage_error("a submission without a scene; expected its digest");
    if (needed_.contains(*digest)) continue;
    want(*digest, frame.scene_size(), store);
    unread_.push_back(*digest);
  }
}

void Submission::want(const Digest& digest, uint64_t size, JobStore& store) {
  if (!needed_.emplace(digest, size).second) return;
  claimed_bytes_ = saturating_sum(claimed_bytes_, size);
  scene_bytes_ = saturating_sum(scene_bytes_, size);
  if (!store.has_blob(digest)) fetch_.want(digest, size);
}

uint64_t Submission::read_scene(const Digest& digest, JobStore& store) {
  const BlobData bytes = store.find_blob(digest);
  if (!bytes) throw render_error("a scene is damaged in the coordinator's store; submit it again");
  const std::string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  const auto scene = parse_scene(text);
  auto facts = scene ? facts_of(*scene) : std::nullopt;
  // Its digest names the scene only in the one form that all write.
  if (!facts || serialize_scene(*scene) != text)
    throw scene_error("the submitted bytes are no scene");
  for (const v1::BlobRef& ref : facts->blobs) want(*Digest::parse(ref.digest()), ref.size(), store);
  if (needed_.size() > kMaxBlobs) throw scene_error("a submission of too many blobs");
  scenes_.emplace(digest, std::move(*facts));
  return bytes->size();
}

void Submission::want_lost(JobStore& store) {
  for (const auto& [digest, size] : needed_) {
    if (!store.has_blob(digest)) fetch_.want(digest, size);
  }
}

std::vector<v1::BlobRequest> Submission::advance(JobStore& store, Time now) {
  for (const auto& [digest, data] : pulled_.all()) store.put_blob(digest, data);
  pulled_ = {};
  uint64_t read = 0;
  while (!unread_.empty() && read < kReadBytes && store.has_blob(unread_.front())) {
    const Digest digest = unread_.front();
    unread_.pop_front();
    constexpr uint64_t kLeast = 4096;
    read += std::max(kLeast, read_scene(digest, store));
  }
  if (finished()) want_lost(store);
  if (!fetch_.failure().empty()) throw render_error(fetch_.failure());
  return fetch_.requests(now);
}

void Submission::fail(v1::JobStatus how) {
  status = std::move(how);
  fetch_ = BlobFetch(request_.submission());
  pulled_ = {};
  unread_.clear();
  scenes_.clear();
  claimed_bytes_ = 0;
}

std::vector<Digest> Submission::blobs() const {
  std::vector<Digest> result;
  for (const auto& [digest, size] : needed_) result.push_back(digest);
  std::sort(result.begin(), result.end());
  return result;
}

}  // namespace tessera
