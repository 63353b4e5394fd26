#pragma once

#include <map>
#include <tuple>
#include <unordered_map>

#include "coordinator/jobs/job_store.h"

namespace tessera {

/// Where a coordinator without a store keeps its jobs: in memory, until its process ends. As a fake
/// of tests it may outlive coordinators (`farm` not 0), and be full.
class MemoryJobStore : public JobStore {
 public:
  explicit MemoryJobStore(uint64_t farm = 0) : farm_(farm) {}

  uint64_t farm() const override { return farm_; }

  std::vector<v1::KeptJob> jobs() override;
  uint64_t last_job() override { return last_job_; }
  void save(const v1::KeptJob& job) override;
  void save_end(uint64_t job, const v1::KeptJob::End& end) override;
  void remove_end(uint64_t job, uint32_t frame) override;
  void remove(uint64_t job, const std::vector<Digest>& tile_keys,
              const std::vector<Digest>& blobs) override;

  uint64_t tile_count(const Digest& key) override;
  std::vector<StoredTile> tiles_traced_by(const std::string& key) override;

  bool has_blob(const Digest& digest) override;
  void put_blob(const Digest& digest, const BlobData& data) override;
  BlobData find_blob(const Digest& digest) override;
  void keep_only_blobs(const std::unordered_set<Digest>& digests) override;

  void keep(const Digest& key, const FinishedTile& tile) override;
  void drop(const Digest& key, const PixelRect& tile) override;
  void drop_all(const Digest& key) override;
  std::vector<FinishedTile> find(const Digest& key) override;

  /// From now on every write fails, or none does.
  void set_full(bool full) { full_ = full; }
  /// From now on no blob and no tile can be read, or all can: as where descriptors ran out.
  void set_unreadable(bool unreadable) { unreadable_ = unreadable; }
  size_t tile_count() const;
  /// As a store that has lost count.
  void set_last_job(uint64_t last_job) { last_job_ = last_job; }

 private:
  void check_room() const;
  void check_readable() const;

  uint64_t farm_;
  bool full_ = false, unreadable_ = false;
  uint64_t last_job_ = 0;
  std::map<uint64_t, v1::KeptJob> jobs_;
  std::unordered_map<Digest, BlobData> blobs_;
  using Place = std::tuple<int, int, int, int>;
  std::map<Digest, std::map<Place, FinishedTile>> tiles_;
};

}  // namespace tessera
