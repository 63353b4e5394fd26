#pragma once

#include <filesystem>
#include <unordered_set>

#include "coordinator/jobs/job_store.h"
#include "coordinator/store/sqlite_database.h"
#include "coordinator/store/tile_table.h"
#include "proto/tessera/v1/farm.pb.h"

namespace tessera {

/// A folder with jobs and finished tiles in SQLite (farm.db) and each blob a file by its digest
/// (blobs/). What was written survives the end of the process at any instant.
class SqliteJobStore : public JobStore {
 public:
  /// Opens the folder or makes it, and counts one epoch more; where a store that is there has no
  /// room for that, keep_epoch() tries again. Throws usage_error where it cannot be
  /// used, another coordinator uses it, or it is something else.
  explicit SqliteJobStore(const std::filesystem::path& folder);

  uint64_t farm() const override { return farm_; }
  uint64_t epoch() const override { return epoch_; }
  void keep_epoch() override;

  SecondsHistogram commit_seconds() const override { return commit_seconds_; }
  std::vector<v1::KeptJob> jobs() override;
  uint64_t last_job() override;
  void save(const v1::KeptJob& job) override;
  void save_end(uint64_t job, const v1::KeptJob::End& end) override;
  void remove_end(uint64_t job, uint32_t frame) override;
  void remove(uint64_t job, const std::vector<Digest>& tile_keys,
              const std::vector<Digest>& blobs) override;

  std::vector<StoredTile> tiles_traced_by(const std::string& key) override;

  bool has_blob(const Digest& digest) override;
  void put_blob(const Digest& digest, const BlobData& data) override;
  BlobData find_blob(const Digest& digest) override;
  void keep_only_blobs(const std::unordered_set<Digest>& digests) override;

  void keep(const Digest& key, const FinishedTile& tile) override;
  void drop(const Digest& key, const PixelRect& tile) override { tiles_.drop(key, tile); }
  void drop_all(const Digest& key) override { tiles_.drop_all(key); }
  std::vector<FinishedTile> find(const Digest& key) override { return tiles_.find(key); }

 private:
  std::filesystem::path blob_path(const Digest& digest) const;
  uint64_t number(const char* name);
  void make_reserve() const;
  /// Does it, and where that fails for want of room once more, having given up the reserve.
  template <typename Write>
  void write_at_last(const Write& write);
  void set_number(const char* name, uint64_t value);

  std::filesystem::path folder_;
  std::unordered_set<Digest> verified_;  ///< blobs, by this process
  SqliteDatabase database_;
  TileTable tiles_;
  uint64_t farm_ = 0, epoch_ = 0;
  bool epoch_kept_ = false;
  SecondsHistogram commit_seconds_;
};

}  // namespace tessera
