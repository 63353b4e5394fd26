#include "front/tile_keeping_farm.h"

#include <spdlog/spdlog.h>

#include <utility>

#include "base/plural.h"
#include "coordinator/store/sqlite_tile_store.h"

namespace tessera {
namespace {

class TileKeepingFarm : public TracingFarm {
 public:
  explicit TileKeepingFarm(std::unique_ptr<TracingFarm> farm) : farm_(std::move(farm)) {}

  JobResult run(JobSpec job, const ProgressCallback& progress,
                const std::atomic<bool>& stop) override {
    if (job.kept_tiles.empty()) return farm_->run(std::move(job), progress, stop);
    const std::filesystem::path file = job.kept_tiles;
    const auto tiles = std::make_shared<SqliteTileStore>(file);
    const Lent lent(*farm_, tiles);
    JobResult result = farm_->run(std::move(job), progress, stop);
    if (result.report.end != JobReport::End::done) return result;
    if (const uint64_t others = tiles->end(); others > 0) {
      spdlog::warn("{} of other scenes or settings stay in '{}'", counted(others, "tile"),
                   file.string());
    }
    return result;
  }
  void watch_tiles(TileCallback done) override { farm_->watch_tiles(std::move(done)); }
  bool attend() override { return farm_->attend(); }
  void wake() override { farm_->wake(); }
  void share(BlobStore& blobs) const override { farm_->share(blobs); }
  uint64_t peak_worker_bytes() const override { return farm_->peak_worker_bytes(); }
  void dismiss() override { farm_->dismiss(); }

 private:
  /// Lends a farm the tiles of one job.
  class Lent {
   public:
    Lent(TracingFarm& farm, std::shared_ptr<TileStore> tiles) : farm_(farm) {
      farm_.keep_tiles(std::move(tiles));
    }
    ~Lent() { farm_.keep_tiles(nullptr); }
    Lent(const Lent&) = delete;
    Lent& operator=(const Lent&) = delete;

   private:
    TracingFarm& farm_;
  };

  std::unique_ptr<TracingFarm> farm_;
};

}  // namespace

std::unique_ptr<TracingFarm> keep_finished_tiles(std::unique_ptr<TracingFarm> farm) {
  return std::make_unique<TileKeepingFarm>(std::move(farm));
}

}  // namespace tessera
