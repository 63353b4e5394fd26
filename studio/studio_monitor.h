#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/monotonic.h"
#include "base/process_usage.h"
#include "coordinator/jobs/farm_snapshot.h"
#include "studio/studio_orders.h"
#include "web/log_ring.h"

namespace tessera {

class Coordinator;

/// How long it takes from an edit to the first pixels of it, as the program sees it: from when its
/// message was taken to when pixels are there to be sent.
class EditLatency {
 public:
  static constexpr size_t kKept = 200;

  /// Texts of that revision are there.
  void note_texts(uint64_t revision, Time now);
  /// A pass of them has been begun.
  void note_pass(uint32_t serial, uint64_t revision);
  /// Pixels of that pass are there.
  void note_pixels(uint32_t serial, Time now);
  /// The time that a share of the last ones took at most, in seconds; nothing: there were none.
  std::optional<double> quantile(double share) const;

 private:
  std::map<uint64_t, Time> texts_;       ///< by revision, while it has no pixels
  std::map<uint32_t, uint64_t> passes_;  ///< revisions by serial, while they have no pixels
  std::deque<double> seconds_;
};

/// Tells pages what the program, its workers and the machine do: a message of workers and one of
/// metrics a second, and the lines of the log. Nothing is looked at while nobody is connected. Used
/// by the coordinator's thread.
class StudioMonitor {
 public:
  static constexpr Time kBetweenSamples = std::chrono::seconds(1);
  static constexpr Time kBetweenLogs = std::chrono::milliseconds(200);

  /// `log` may be null.
  explicit StudioMonitor(std::shared_ptr<const LogRing> log) : log_(std::move(log)) {}

  EditLatency& latency() { return latency_; }
  /// What is due, for pages that are `connected`.
  std::vector<SendText> look(const Coordinator& coordinator, const std::vector<ClientId>& connected,
                             Time now);

 private:
  struct Sample {
    Time at{};
    FarmSnapshot::Counters counters;
    MachineUsage machine;
    double program_seconds = 0;                               ///< of processor time
    std::map<std::string, double> workers{};                  ///< of processor time, by name
    std::map<uint64_t, std::pair<uint64_t, double>> tiles{};  ///< of workers: done, and seconds
  };
  nlohmann::json metrics(const FarmSnapshot& farm, const Sample& sample) const;
  nlohmann::json workers(const FarmSnapshot& farm, const Sample& sample) const;
  void add_log(const std::vector<ClientId>& connected, std::vector<SendText>& messages);

  std::shared_ptr<const LogRing> log_;
  EditLatency latency_;
  std::map<ClientId, uint64_t> logged_;  ///< the last line that each has
  std::optional<Sample> last_;
  Time next_sample_{}, next_log_{};
};

}  // namespace tessera
