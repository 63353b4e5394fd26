#pragma once

#include <filesystem>
#include <string>
#include <unordered_set>
#include <vector>

#include "base/monotonic.h"
#include "coordinator/jobs/job_store.h"
#include "coordinator/store/blob_folder.h"
#include "coordinator/store/sqlite_database.h"
#include "coordinator/store/tile_table.h"
#include "proto/tessera/v1/farm.pb.h"

namespace tessera {

/// A folder with jobs and finished tiles in SQLite (farm.db) and each blob a file by its digest
/// (blobs/). What was written survives the end of the process at any instant.
///
/// The file `state` beside them says which jobs the folder has had. A database that is missing,
/// empty, older than that or of another store is refused, as blobs and jobs would be lost with it.
class SqliteJobStore : public JobStore {
 public:
  /// Opens the folder or makes it. Throws temporary_error where it may do later (another process
  /// uses it, the disk is full) and usage_error where it is damaged, is not whole or is something
  /// else.
  explicit SqliteJobStore(const std::filesystem::path& folder);

  uint64_t farm() const override { return farm_; }

  SecondsHistogram commit_seconds() const override { return commit_seconds_; }
  /// Leaves out jobs whose rows are damaged, which it logs: their rows and all blobs are kept.
  std::vector<v1::KeptJob> jobs() override;
  uint64_t last_job() override;
  void save(const v1::KeptJob& job) override;
  void save_end(uint64_t job, const v1::KeptJob::End& end) override;
  void remove_end(uint64_t job, uint32_t frame) override;
  void remove(uint64_t job, const std::vector<Digest>& tile_keys,
              const std::vector<Digest>& blobs) override;
  uint64_t tile_count(const Digest& key) override { return tiles_.count(key); }
  std::vector<StoredTile> tiles_traced_by(const std::string& key) override {
    return tiles_.traced_by(key);
  }

  bool has_blob(const Digest& digest) override { return blobs_.has(digest); }
  void put_blob(const Digest& digest, const BlobData& data) override;
  BlobData find_blob(const Digest& digest) override { return blobs_.find(digest); }
  /// Deletes a blob that no job needs once it was found so a week ago, by this database.
  void keep_only_blobs(const std::unordered_set<Digest>& digests) override;

  void keep(const Digest& key, const FinishedTile& tile) override;
  void drop(const Digest& key, const PixelRect& tile) override { tiles_.drop(key, tile); }
  void drop_all(const Digest& key) override;
  std::vector<FinishedTile> find(const Digest& key) override { return tiles_.find(key); }

  void tidy() override;

 private:
  uint64_t number(const char* name);
  void set_number(const char* name, uint64_t value);
  void check_state();
  void write_state(uint64_t last_job) const;
  void make_reserve() const;
  /// Does it, and where that fails for want of room once more, having given up the reserve.
  template <typename Write>
  void write_at_last(const Write& write);
  /// Gives unused pages back to the disk for so long; the rest another time.
  void give_back(Time most);

  std::filesystem::path folder_;
  BlobFolder blobs_;
  SqliteDatabase database_;
  TileTable tiles_;
  uint64_t farm_ = 0;
  bool leaves_out_jobs_ = false;
  bool may_give_back_ = true;
  SecondsHistogram commit_seconds_;
};

}  // namespace tessera
