#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <queue>
#include <random>
#include <string>
#include <vector>

#include "client/job_client.h"
#include "coordinator/coordinator.h"
#include "coordinator/tiles/identity.h"
#include "tests/farm/fake_renderer.h"
#include "worker/session_spool.h"

namespace tessera::testing {

/// What goes wrong, and how often. Drawn from the seed, so that each seed has another mix.
struct Faults {
  double loss = 0, duplication = 0, corruption = 0;
  Time delay = std::chrono::milliseconds(1);  ///< the most, of each message
  bool in_order = true;
  int events = 0;            ///< crashes, freezes, partitions, joins ... in the first 20 s
  bool split_bands = false;  ///< every row a message
  bool as_frames = false;    ///< messages go through encode() and decode()
  bool by_client = false;    ///< the job comes from a client
  bool one_fails = false;    ///< the first worker fails its first two tiles
  bool one_hangs = false;    ///< the second worker's first tile never ends
  bool one_lies = false;     ///< the third worker's pixels are wrong
  bool one_alone = false;    ///< there is but one worker
  uint64_t keys = 0;         ///< of workers, who take turns at them; 0: there are none
  bool key_lies = false;     ///< all workers of the first key, alike
  bool bad_scene = false;    ///< no worker can build the scene
  bool one_starves = false;  ///< the first worker has memory for one tile at a time
  bool restarts = false;     ///< the coordinator dies once, and another takes its place
  Time coordinator_stops{};  ///< for so long the coordinator is stopped once
  /// Workers that hear nothing for so long end, and others take their place.
  Time orphan_timeout = Time::max();
  uint64_t result_bytes = uint64_t{1} << 20;  ///< what each keeps of its results in memory
};

/// The whole farm in one thread under a simulated clock: the real Coordinator, WorkerSessions and
/// JobClient; only sockets, threads and tracing are played. Everything follows from the seed.
class Simulation {
 public:
  explicit Simulation(uint64_t seed,
                      const std::function<void(Faults&, CoordinatorOptions&)>& adjust = {});
  virtual ~Simulation() = default;

  /// Runs to the end of the job; nothing if it does not end within ten minutes of simulated time.
  std::optional<JobResult> run();

  const JobSpec& job() const { return job_; }
  const Faults& faults() const { return faults_; }
  Time now() const { return now_; }
  uint64_t messages() const { return messages_; }
  /// Workers that had been stopped, and took the coordinator for silent before it could answer.
  int hasty_workers() const { return hasty_workers_; }
  bool trace = false;  ///< tell on standard error what happens

 protected:
  // What a simulation of more than one job does otherwise.
  /// Calls the coordinator.
  virtual void with_coordinator(const std::function<void(Coordinator&)>& act) {
    act(*coordinator_);
  }
  /// Why no worker has the memory for the scene now, if that is so.
  virtual std::optional<std::string> cannot_build(const v1::Scene&) { return std::nullopt; }
  /// Sees what the coordinator sends.
  virtual void note_sent(const OutgoingMessage&) {}
  /// True if that peer is a client of it, which has then heard the message.
  virtual bool tell_client(const PeerId& peer, Channel channel, const v1::Envelope& message);
  virtual Time next_client_time() const;
  virtual void tick_clients();

  /// Where workers leave results that they cannot hand in; empty: nowhere.
  virtual std::filesystem::path spool_folder() { return {}; }

  struct Worker {
    std::unique_ptr<WorkerSession> session;
    std::unique_ptr<ResultSpool> spool;  ///< null: none
    bool was_welcome = false;
    PeerId peer;
    uint32_t process = 0;
    int failures_left = 0;  ///< two do not make a tile given up
    AllowedKey key;
    bool lies = false;
    bool starves = false;
    bool hangs = false;  ///< from its next tile on
    bool drains = false;
    double slowness = 1;
    Time frozen_from{}, frozen_until{};  ///< stopped
    Time cut_until{};                    ///< separated from the coordinator
    bool cut_to = false, cut_from = false;
    size_t busy = 0;
    std::deque<std::shared_ptr<TraceRun>> queue;
    std::map<TraceRun*, std::pair<std::shared_ptr<TraceRun>, Time>> tracing;  ///< since when
  };
  struct Event {
    Time time{};
    uint64_t order = 0;
    std::function<void()> act;
    bool operator<(const Event& other) const {
      return std::pair(time, order) > std::pair(other.time, other.order);
    }
  };

  /// After so long a process that goes on has read what came while it was stopped.
  static constexpr Time kRead = std::chrono::milliseconds(1);
  /// The machine of the coordinator and of some workers.
  static constexpr char kHost[] = "simulated";

  double draw() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  uint64_t draw(uint64_t below) { return random_() % below; }
  Time draw_time(Time most) {
    return Time(static_cast<int64_t>(draw() * static_cast<double>(most.count())));
  }
  void draw_faults();
  void say(const std::string& text) const;

  void at(Time time, std::function<void()> act);
  /// Plays the network: `arrive` is called never, once or twice, now or later.
  void carry(const v1::Envelope& message, const std::string& line,
             const std::function<void(const v1::Envelope&)>& arrive);
  Worker* find(const PeerId& peer);
  Worker* find_process(uint32_t process);
  void join();
  void crash(uint32_t process, bool noticed, bool own_fault);
  void end_drain(uint32_t process);
  void something_happens();
  void thaw_all();
  /// How the coordinator of that number calls itself.
  static std::string opening_of(uint64_t number) { return job_id_of("simulated", number); }
  /// A new coordinator with a new job, whose picture is another.
  void restart_coordinator();
  /// Stops it for a time some seconds from now, where faults want that.
  void plan_stop();
  void submit();

  void to_coordinator(Channel channel, const PeerId& peer, const v1::Envelope& message);
  void deliver();
  void perform(Worker& worker);
  void hand_in(Worker& worker);
  void leave_results(Worker& worker);
  /// Of tracing that, for a worker of ordinary speed.
  double seconds_of(const TraceRun& run) const;
  void start_tracing(Worker& worker);
  void finish_tracing(uint32_t process, const std::shared_ptr<TraceRun>& run);
  TraceOutcome outcome_of(Worker& worker, const std::shared_ptr<TraceRun>& run);
  void deliver_client();
  void tick();
  Time next_time() const;

  std::mt19937_64 random_;
  Faults faults_;
  double pace_ = 1;  ///< of tracing: larger is slower
  JobSpec job_;
  Time now_ = std::chrono::seconds(1000);
  uint64_t openings_ = 1;
  uint64_t order_ = 0, messages_ = 0;
  std::priority_queue<Event> events_;
  std::map<std::string, Time> last_arrival_;  ///< by line, where messages keep their order
  CoordinatorOptions options_;
  std::unique_ptr<Coordinator> coordinator_;
  Time coordinator_stopped_until_{};
  uint64_t id_ = 0;  ///< of the job, where no client asks for it
  std::map<uint32_t, Worker> workers_;
  uint32_t processes_ = 0, peers_ = 0;
  uint64_t handed_in_ = 0;  ///< results of processes that had ended, or for which there was no room
  std::unique_ptr<JobClient> client_;
  bool quiet_ = false;  ///< nothing goes wrong any more
  int hasty_workers_ = 0;
};

}  // namespace tessera::testing
