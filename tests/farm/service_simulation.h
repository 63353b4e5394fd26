#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "coordinator/jobs/memory_job_store.h"
#include "proto/wire/blob_store.h"
#include "tests/farm/simulation.h"
#include "tests/temporary_folder.h"

namespace tessera::testing {

/// Thrown at a write of the store: the coordinator is killed there.
struct Killed {};

/// A store in memory that survives coordinators, and may kill one just before or after any write.
class MortalStore : public MemoryJobStore {
 public:
  MortalStore() : MemoryJobStore(7) {}
  /// The write after so many more kills; `after`: once it is done.
  void kill_at(int writes, bool after) {
    left_ = writes;
    after_ = after;
  }
  void save(const v1::KeptJob& job) override {
    write([&] { MemoryJobStore::save(job); });
  }
  void save_end(uint64_t job, const v1::KeptJob::End& end) override {
    write([&] { MemoryJobStore::save_end(job, end); });
  }
  void put_blob(const Digest& digest, const BlobData& data) override {
    write([&] { MemoryJobStore::put_blob(digest, data); });
  }
  void keep(const Digest& key, const FinishedTile& tile) override {
    write([&] { MemoryJobStore::keep(key, tile); });
  }

 private:
  template <typename Act>
  void write(const Act& act) {
    const bool dies = left_ == 0;
    if (left_ >= 0) --left_;
    if (dies && !after_) throw Killed{};
    act();
    if (dies) throw Killed{};
  }
  int left_ = -1;  ///< below 0: none
  bool after_ = false;
};

/// What goes wrong with a service beside what goes wrong with its workers.
struct ServiceFaults {
  int jobs = 1;
  int orders = 0;  ///< pauses, resumptions, cancellations, new priorities
  int kills = 0;   ///< of the coordinator, each at some write of the store
  bool full = false;
  bool spools = false;    ///< workers end when they are orphans for long, and leave their results
  bool restores = false;  ///< once, a copy that was made before takes the place of the store
};

/// Many jobs on a coordinator that is killed and started again from its store.
class ServiceSimulation : public Simulation {
 public:
  explicit ServiceSimulation(uint64_t seed);

  /// Runs until all jobs have ended; what was wrong, or nothing.
  std::string run_service();
  const ServiceFaults& service() const { return service_; }
  int restarts() const { return restarts_; }
  int cancelled() const { return cancelled_; }
  uint64_t restored() const { return restored_; }
  uint64_t handed_in() const { return handed_in_; }

 private:
  /// Somebody who submits one job and then gives orders about it.
  struct Client {
    v1::SubmitJob request;
    BlobStore blobs;
    std::vector<Digest> films;  ///< of each frame, as it must be
    uint64_t job = 0;           ///< once it is accepted
    v1::JobQuery::Action wants = v1::JobQuery::ASK;
    std::optional<int32_t> priority{};  ///< that it orders
    bool ended = false;
    Time next_question{};
  };

  void with_coordinator(const std::function<void(Coordinator&)>& act) override;
  void note_sent(const OutgoingMessage& message) override;
  std::optional<std::string> cannot_build(const v1::Scene& scene) override;
  bool tell_client(const PeerId& peer, Channel channel, const v1::Envelope& message) override;
  Time next_client_time() const override;
  void tick_clients() override;

  std::filesystem::path spool_folder() override;

  void come(int number);
  void ask(const PeerId& peer, Client& client);
  void on_status(Client& client, const v1::JobStatus& status);
  void give_order();
  void restart();
  /// The store becomes what it was; whose jobs are gone submits them anew.
  void restore(const MortalStore& copy);
  std::string verdict();
  /// Whether jobs that clients heard had ended have to end once more: the word came late, from
  /// before a copy of the store was restored.
  bool end_again();

  ServiceFaults service_;
  std::shared_ptr<MortalStore> store_ = std::make_shared<MortalStore>();
  std::optional<TemporaryFolder> spool_;
  std::map<PeerId, Client> clients_;
  std::string flaw_;
  int restarts_ = 0, cancelled_ = 0;
  uint64_t restored_ = 0;
};

}  // namespace tessera::testing
