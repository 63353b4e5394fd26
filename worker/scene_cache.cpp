#include "worker/scene_cache.h"

#include <algorithm>
#include <utility>

#include "proto/wire/scene_codec.h"

namespace tessera {
namespace {

constexpr size_t kTracersKept = 2;

}  // namespace

bool SceneCache::begin(const v1::JobStart& start, uint64_t budget_bytes) {
  if (start.blobs_size() != start.blob_sizes_size()) return false;
  start_ = start;
  // Equal settings serialise equally: FrameSettings holds no map.
  key_ = start.scene_digest() + start.frame().SerializeAsString();
  make_room(budget_bytes);
  fetch_ = BlobFetch(0, sources_.shared_memory);
  lookups_.clear();
  const auto want = [this](const std::string& hex, uint64_t size) {
    const auto digest = Digest::parse(hex);
    if (!digest) return false;
    if (blobs_.find(*digest)) return true;
    if (sources_.disk) {
      fetch_.hold(*digest, size);
      lookups_.push_back({*digest, size});
    } else {
      fetch_.want(*digest, size);
    }
    return true;
  };
  if (!want(start.scene_digest(), start.scene_size())) return false;
  for (int i = 0; i < start.blobs_size(); ++i) {
    if (!want(start.blobs(i), start.blob_sizes(i))) return false;
  }
  return true;
}

void SceneCache::on_place(const v1::BlobPlace& place) {
  const auto size = fetch_.on_place(place);
  if (!size) return;
  const BlobPlace there{static_cast<int>(place.process_id()), static_cast<int>(place.file())};
  lookups_.push_back({*Digest::parse(place.digest()), *size, there});
}

void SceneCache::make_room(uint64_t budget_bytes) {
  uint64_t bytes = 0;
  for (const auto& [digest, data] : blobs_.all()) bytes += data->size();
  if (bytes <= budget_bytes) return;
  BlobStore kept;
  const auto keep = [&](const std::string& hex) {
    const auto digest = Digest::parse(hex);
    const BlobData data = digest ? blobs_.find(*digest) : nullptr;
    if (data) kept.put(*digest, data);
  };
  keep(start_.scene_digest());
  for (const std::string& hex : start_.blobs()) keep(hex);
  blobs_ = std::move(kept);
}

std::shared_ptr<const TileRenderer> SceneCache::built() const {
  const auto it = std::find_if(built_.begin(), built_.end(),
                               [this](const Built& built) { return built.key == key_; });
  return it == built_.end() ? nullptr : it->renderer;
}

void SceneCache::keep(std::shared_ptr<const TileRenderer> renderer) {
  built_.push_front({key_, std::move(renderer)});
  if (built_.size() > kTracersKept) built_.pop_back();
}

std::optional<BuildRun> SceneCache::input() const {
  const auto digest = Digest::parse(start_.scene_digest());
  const BlobData bytes = digest ? blobs_.find(*digest) : nullptr;
  if (!bytes) return std::nullopt;
  auto scene = parse_scene({reinterpret_cast<const char*>(bytes->data()), bytes->size()});
  if (!scene) return std::nullopt;
  return BuildRun{start_.job(), std::move(*scene), blobs_, start_.frame()};
}

}  // namespace tessera
