#include "coordinator/jobs/memory_job_store.h"

#include <algorithm>

#include "base/error.h"

namespace tessera {

void MemoryJobStore::check_room() const {
  if (full_) throw render_error("the store is full");
}

void MemoryJobStore::check_readable() const {
  if (unreadable_) throw temporary_error("the store cannot be read now");
}

std::vector<v1::KeptJob> MemoryJobStore::jobs() {
  std::vector<v1::KeptJob> result;
  for (const auto& [id, job] : jobs_) result.push_back(job);
  return result;
}

void MemoryJobStore::save(const v1::KeptJob& job) {
  check_room();
  v1::KeptJob& kept = jobs_[job.job()];
  const auto ends = std::move(*kept.mutable_ends());
  kept = job;
  *kept.mutable_ends() = ends;
  last_job_ = std::max(last_job_, job.job());
}

void MemoryJobStore::save_end(uint64_t job, const v1::KeptJob::End& end) {
  check_room();
  *jobs_.at(job).add_ends() = end;
}

void MemoryJobStore::remove_end(uint64_t job, uint32_t frame) {
  check_room();
  auto& ends = *jobs_.at(job).mutable_ends();
  const auto is_of_frame = [frame](const v1::KeptJob::End& end) { return end.frame() == frame; };
  ends.erase(std::remove_if(ends.begin(), ends.end(), is_of_frame), ends.end());
}

void MemoryJobStore::remove(uint64_t job, const std::vector<Digest>& tile_keys,
                            const std::vector<Digest>& blobs) {
  check_room();
  jobs_.erase(job);
  for (const Digest& key : tile_keys) tiles_.erase(key);
  for (const Digest& blob : blobs) blobs_.erase(blob);
}

uint64_t MemoryJobStore::tile_count(const Digest& key) {
  check_readable();
  const auto it = tiles_.find(key);
  return it == tiles_.end() ? 0 : it->second.size();
}

std::vector<StoredTile> MemoryJobStore::tiles_traced_by(const std::string& tracer) {
  std::vector<StoredTile> found;
  for (const auto& [key, tiles] : tiles_) {
    for (const auto& [place, tile] : tiles) {
      const auto& tracers = tile.kept.tracers();
      if (std::ranges::find(tracers, tracer) != tracers.end()) found.push_back({key, tile.rect});
    }
  }
  return found;
}

bool MemoryJobStore::has_blob(const Digest& digest) {
  check_readable();
  return blobs_.contains(digest);
}

void MemoryJobStore::put_blob(const Digest& digest, const BlobData& data) {
  check_room();
  blobs_.emplace(digest, data);
}

BlobData MemoryJobStore::find_blob(const Digest& digest) {
  check_readable();
  const auto it = blobs_.find(digest);
  return it == blobs_.end() ? nullptr : it->second;
}

void MemoryJobStore::keep_only_blobs(const std::unordered_set<Digest>& digests) {
  std::erase_if(blobs_, [&](const auto& blob) { return !digests.contains(blob.first); });
}

void MemoryJobStore::keep(const Digest& key, const FinishedTile& tile) {
  check_room();
  const PixelRect& r = tile.rect;
  tiles_[key].insert_or_assign({r.x0, r.y0, r.x1, r.y1}, tile);
}

void MemoryJobStore::drop(const Digest& key, const PixelRect& r) {
  check_room();
  const auto it = tiles_.find(key);
  if (it != tiles_.end()) it->second.erase({r.x0, r.y0, r.x1, r.y1});
}

void MemoryJobStore::drop_all(const Digest& key) {
  check_room();
  tiles_.erase(key);
}

std::vector<FinishedTile> MemoryJobStore::find(const Digest& key) {
  check_readable();
  std::vector<FinishedTile> result;
  const auto it = tiles_.find(key);
  if (it == tiles_.end()) return result;
  for (const auto& [place, tile] : it->second) result.push_back(tile);
  return result;
}

size_t MemoryJobStore::tile_count() const {
  size_t count = 0;
  for (const auto& [key, tiles] : tiles_) count += tiles.size();
  return count;
}

}  // namespace tessera
