#pragma once

#include <sys/types.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/silence.h"
#include "base/tally.h"
#include "coordinator/coordinator_options.h"
#include "coordinator/local_workers.h"
#include "job/job.h"
#include "proto/tessera/v1/farm.pb.h"
#include "proto/transport/transport.h"

namespace tessera {

class Coordinator;
class JobStore;
class KeyRegistry;
class TileStore;

/// Moves messages between a ServerTransport, which it owns, and a Coordinator. Used by one thread,
/// except for wake().
class RenderLoop {
 public:
  /// `store` as for Coordinator.
  RenderLoop(std::unique_ptr<ServerTransport> transport, const CoordinatorOptions& options,
             std::shared_ptr<JobStore> store = nullptr);
  ~RenderLoop();

  /// Where workers connect to; of several endpoints, the first.
  std::string endpoint() const { return transport_->endpoint(); }
  std::vector<std::string> endpoints() const { return transport_->endpoints(); }

  /// Worker processes to watch and replace while this runs; may be null. The caller keeps them.
  void watch(LocalWorkers* workers) { local_workers_ = workers; }

  /// Renders one job to its end, or until `stop` is set (then its end is `interrupted`, and the
  /// film holds what came until then; `stop` is looked at every 50 ms). May be called again for
  /// further jobs: workers stay. If local workers cannot be kept alive, the job fails. Throws
  /// usage_error for a frame, crop or tile size that cannot be, and whatever `progress` throws or
  /// memory is short of; others may be rendered after that. `tiles` as of
  /// Coordinator::submit().
  JobResult run(JobSpec job, const ProgressCallback& progress, const std::atomic<bool>& stop,
                std::shared_ptr<TileStore> tiles = nullptr);

  /// Answers workers for at most 50 ms, or until wake(): between jobs.
  void attend() { step(kLongestWait); }

  /// Calls `look` from now on: where messages come, within `every`; at once when there are
  /// Coordinator::news(); else when the loop wakes for something else, some 20 times a second. On
  /// the thread that runs or serves: for a page or a monitor.
  void observe(std::function<void(Coordinator&, Time now)> look, Time every);
  /// Ends the wait for messages that is under way, or else the next one, and has the observer
  /// called right after it, though it be not due. What the observer submits or interrupts leaves
  /// for the workers in the same round. Any thread may call this, as long as this object lives.
  void wake();
  /// Serves workers and clients that submit jobs until `stop` is set; then for at most `drain`
  /// until the workers have sent what they trace. `each_round`, where given, is called at least
  /// every 50 ms until then.
  void serve(const std::atomic<bool>& stop, Time drain = Time{0},
             const std::function<void()>& each_round = {});
  /// Replaces the list of admitted keys. Peers that are not on it any more are lost at once; those
  /// whose key was quarantined may come back.
  void set_allowed(AllowList allowed);
  /// Where machines enrol, by tokens that are let in. The caller keeps it; null: nowhere.
  void enrol_into(KeyRegistry* keys) { keys_ = keys; }

  /// Tells every worker to end. The message leaves while this object or, for up to 500 ms, its
  /// destructor lives.
  void shut_down(const std::string& reason);
  /// The same for workers on other hosts, and goes on for a moment: a TCP connection that is closed
  /// with messages unread takes back what was just sent, and some worker may be about to say hello.
  void bid_farewell(const std::string& reason);

 private:
  static constexpr Time kLongestWait = std::chrono::milliseconds(50);

  /// Of a job that was submitted here.
  JobResult wait_for(uint64_t id, const ProgressCallback& progress, const std::atomic<bool>& stop);
  /// Waits for messages for at most `pause`, and handles what came and what is due.
  void step(Time pause);
  void receive();
  /// Answers what the sender's key is not for.
  void turn_away(const ReceivedMessage& received, const v1::Reject& reject);
  /// Answers a machine that makes its key known, which is let in before it hears of it.
  void enrol(const ReceivedMessage& received, const v1::Enrol& request);
  void let_in(AllowList allowed);
  void deliver();
  /// Adds what the coordinator does not know, as its peers come by a transport: where that peer
  /// finds blobs, and whether it shall pack its pixels.
  void tell_way(const PeerId& peer, v1::Envelope& message) const;
  void attend_local_workers(Time now);
  /// Kills local workers that were stopped before they could say hello.
  void kill_silent(Time now);

  std::unique_ptr<ServerTransport> transport_;
  std::unique_ptr<Coordinator> coordinator_;
  LocalWorkers* local_workers_ = nullptr;
  KeyRegistry* keys_ = nullptr;
  Time greeting_;  ///< as in CoordinatorOptions
  std::map<pid_t, std::optional<Silence>>
      silent_since_;                    ///< local workers that have not said hello
  Time next_look_{};                    ///< at local workers
  uint64_t tiles_done_ = 0;             ///< when last looked at
  Tally garbage_;                       ///< messages that nobody can read
  std::set<std::string> told_refused_;  ///< names of keys, at most as many as are on the list
  std::function<void(Coordinator&, Time)> observer_;
  Time observe_every_{}, next_observation_{};
  uint64_t observed_news_ = 0;
  bool is_unobserved_ = false;      ///< a message has come since the observer was last called
  std::atomic<bool> woken_{false};  ///< by wake(), since the observer was last called
};

}  // namespace tessera
