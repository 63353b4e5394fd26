#include "worker/scene_cache.h"

#include <algorithm>
#include <utility>

namespace tessera {
namespace {

constexpr size_t kTracersKept = 2;

/// Equal settings serialise equally: FrameSettings holds no map.
std::string key_of(const v1::JobStart& start) {
  return start.scene_digest() + start.frame().SerializeAsString();
}

}  // namespace

std::optional<BlobFetch> SceneCache::want(const v1::JobStart& start,
                                          std::vector<BlobLookup>& lookups) {
  if (start.blobs_size() != start.blob_sizes_size()) return std::nullopt;
  BlobFetch fetch(0, sources_.shared_memory);
  const auto want_blob = [&](const std::string& hex, uint64_t size) {
    const auto digest = Digest::parse(hex);
    if (!digest || blobs_.find(*digest)) return digest.has_value();
    if (const BlobData blob = sources_.at_hand ? sources_.at_hand(*digest) : nullptr) {
      blobs_.put(*digest, blob);
      return true;
    }
    if (sources_.disk) {
      fetch.hold(*digest, size);
      lookups.push_back({*digest, size});
    } else {
      fetch.want(*digest, size);
    }
    return true;
  };
  if (!want_blob(start.scene_digest(), start.scene_size())) return std::nullopt;
  for (int i = 0; i < start.blobs_size(); ++i) {
    if (!want_blob(start.blobs(i), start.blob_sizes(i))) return std::nullopt;
  }
  return fetch;
}

void SceneCache::make_room(const std::vector<const v1::JobStart*>& jobs, uint64_t budget_bytes) {
  uint64_t bytes = 0;
  for (const auto& [digest, data] : blobs_.all()) bytes += data->size();
  if (bytes <= budget_bytes) return;
  BlobStore kept;
  const auto keep = [&](const std::string& hex) {
    const auto digest = Digest::parse(hex);
    const BlobData data = digest ? blobs_.find(*digest) : nullptr;
    if (data) kept.put(*digest, data);
  };
  for (const v1::JobStart* job : jobs) {
    keep(job->scene_digest());
    for (const std::string& hex : job->blobs()) keep(hex);
  }
  blobs_ = std::move(kept);
}

std::shared_ptr<const TileRenderer> SceneCache::built(const v1::JobStart& start) const {
  const auto it = std::find_if(built_.begin(), built_.end(),
                               [key = key_of(start)](const Built& b) { return b.key == key; });
  return it == built_.end() ? nullptr : it->renderer;
}

void SceneCache::keep(const v1::JobStart& start, std::shared_ptr<const TileRenderer> renderer) {
  built_.push_front({key_of(start), std::move(renderer)});
  if (built_.size() > kTracersKept) built_.pop_back();
}

std::shared_ptr<BuildRun> SceneCache::input(const v1::JobStart& start) const {
  const auto digest = Digest::parse(start.scene_digest());
  BlobData bytes = digest ? blobs_.find(*digest) : nullptr;
  if (!bytes) return nullptr;
  auto run = std::make_shared<BuildRun>();
  run->job = start.job();
  run->frame_id = start.frame_id();
  run->scene_bytes = std::move(bytes);
  run->blobs = blobs_;
  run->frame = start.frame();
  return run;
}

}  // namespace tessera
