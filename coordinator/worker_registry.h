#pragma once

#include <sys/types.h>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "base/monotonic.h"
#include "base/tally.h"
#include "coordinator/coordinator_options.h"
#include "coordinator/tiles/tile_scheduler.h"
#include "proto/tessera/v1/farm.pb.h"
#include "proto/transport/allow_list.h"
#include "proto/transport/transport.h"

namespace tessera {

enum class WorkerState { active, suspect, lost };

/// A worker that was accepted at some time.
struct WorkerRecord {
  WorkerId id = 0;
  PeerId peer;
  AllowedKey sender;  ///< whose key its id is bound to, where there are keys
  v1::Hello hello;
  WorkerState state = WorkerState::active;
  /// Its connection is gone: what still comes by it was sent before, and brings nobody back.
  bool unreachable = false;
  Time last_heard{};
  Time answered{};   ///< with its last Ping
  int failures = 0;  ///< tiles that it failed
  struct KnownJob {
    Time told{};         ///< when it was last sent
    bool ready = false;  ///< its scene is built
  };
  std::map<uint64_t, KnownJob> jobs;  ///< that it was sent
  Time came{};                        ///< with its last session
  uint64_t tiles_done = 0;            ///< that it was first to complete
  double tile_seconds = 0;            ///< from assignment to completion, sum over those
  uint64_t bytes_results = 0;         ///< of pixels, as they came
  uint64_t resident_bytes = 0;        ///< as it said last
  uint64_t work_told = 0;             ///< on what it holds, by its last heartbeat
  Time got_on{};                      ///< when it was last seen to trace or build
  bool leaves = false;                ///< it takes no more tiles
  Tally losses{std::chrono::minutes(1)}, complaints{}, returns{};  ///< told of it
  bool told_lost = false;                                          ///< and not yet that it is back
  size_t foreign = 0;  ///< tiles that keep it busy though they are no longer its own

  bool ready_for(uint64_t job) const;
  /// "host:process", for messages.
  std::string name() const;
};

/// The answer to a hello under an id that is another's.
v1::Reject id_taken(const v1::Hello& hello);

/// Who works here. A worker is known by the id that its process drew; a connection is only its
/// address of the moment. Where there are keys, an id is its alone whose key said it first.
/// Of the coordinator's thread.
class WorkerRegistry {
 public:
  explicit WorkerRegistry(const CoordinatorOptions& options) : options_(options) {}

  /// Why a hello by that key cannot be accepted, or nothing.
  std::optional<v1::Reject> judge(const v1::Hello& hello, const AllowedKey& sender = {}) const;
  /// Why one that was accepted is refused by now, or nothing.
  std::optional<v1::Reject> judge(const WorkerRecord& worker) const {
    return judge_aside(worker.id, worker.sender);
  }
  struct Greeting {
    WorkerRecord* worker = nullptr;  ///< null: one too many, or `older`
    bool older = false;              ///< of a session before one that was heard: changes nothing
    bool anew = false;               ///< the first of this session: what it held is forgotten
    bool known = false;              ///< by an earlier session
    std::string before{};            ///< its name until now, where it comes by another connection
  };
  /// Registers a hello that judge() has nothing against.
  Greeting greet(const PeerId& peer, const v1::Hello& hello, Time now,
                 const AllowedKey& sender = {});

  // Null where there is none; valid until the worker is forgotten.
  WorkerRecord* by_peer(const PeerId& peer);
  WorkerRecord* by_id(WorkerId id);
  /// The worker in that process of this host.
  WorkerRecord* by_process(pid_t process);
  bool knows_process(pid_t process) const;

  /// Any message counts as a sign of life. True if it was lost and is now back.
  bool heard(WorkerRecord& worker, Time now);
  void lose(WorkerRecord& worker);
  /// Refuses it from now on, and says why.
  void set_aside(WorkerId worker, const std::string& cause);
  /// Refuses all workers of a key, until forgive_keys().
  void set_key_aside(const std::string& key, const std::string& cause);
  /// What was counted against keys counts no more.
  void forgive_keys() { blame_.clear(); }
  /// Counts a tile that it failed; how many are counted against its key now, or against itself
  /// where there are no keys: an id is only what its process drew.
  int blame(WorkerRecord& worker);
  int blamed(const WorkerRecord& worker) const;
  /// Those that came by that key.
  std::vector<WorkerRecord*> with_key(const std::string& key);

  struct Silence {
    std::vector<WorkerRecord*> suspects;  ///< newly so
    std::vector<WorkerRecord*> lost;      ///< to be given to lose()
  };
  Silence check(Time now);
  /// As WorkerService::forgive().
  void forgive(Time silence, Time now);
  /// Those not lost.
  std::vector<WorkerRecord*> present();
  int present_count() const;
  /// That those trace with.
  uint32_t present_threads() const;
  const std::map<WorkerId, WorkerRecord>& all() const { return workers_; }

 private:
  void forget_lost();
  std::optional<v1::Reject> judge_aside(WorkerId id, const AllowedKey& sender) const;

  CoordinatorOptions options_;
  std::map<WorkerId, WorkerRecord> workers_;
  std::unordered_map<PeerId, WorkerRecord*> by_peer_;
  std::map<WorkerId, std::string> set_aside_;  ///< with the cause
  struct Blame {
    int failures = 0;
    std::optional<std::string> set_aside;  ///< why
  };
  std::map<std::string, Blame> blame_;  ///< by key
};

}  // namespace tessera
