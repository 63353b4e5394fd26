#include "front/job_status.h"

#include <nlohmann/json.hpp>

#include "proto/wire/printable.h"

namespace tessera {

std::string state_name(const v1::JobStatus& status) {
  switch (status.state()) {
    case v1::JobStatus::QUEUED:
      return "queued";
    case v1::JobStatus::RUNNING:
      return "running";
    case v1::JobStatus::PAUSED:
      return "paused";
    case v1::JobStatus::HELD:
      return "held";
    case v1::JobStatus::ENDED:
      return status.how() == v1::JobEnd::DONE          ? "done"
             : status.how() == v1::JobEnd::INTERRUPTED ? "cancelled"
                                                       : "failed";
    default:
      return "unknown";
  }
}

int percent(const v1::JobStatus& status) {
  if (status.tiles_total() == 0) return 0;
  return static_cast<int>(100 * status.tiles_done() / status.tiles_total());
}

nlohmann::ordered_json status_json(const v1::JobStatus& status) {
  using json = nlohmann::ordered_json;
  json result;
  result["job"] = status.job();
  result["name"] = printable(status.name());
  result["state"] = state_name(status);
  const std::string waits_for = printable(status.waits_for());
  result["waits_for"] = waits_for.empty() ? json(nullptr) : json(waits_for);
  result["priority"] = status.priority();
  result["weight"] = status.weight();
  result["frames"] = {{"done", status.frames_done()}, {"total", status.frames_total()}};
  result["tiles"] = {{"done", status.tiles_done()},
                     {"total", status.tiles_total()},
                     {"restored", status.tiles_restored()}};
  result["elapsed_seconds"] = status.elapsed_seconds();
  const bool known = status.remaining_seconds() >= 0;
  result["remaining_seconds"] = known ? json(status.remaining_seconds()) : json(nullptr);
  result["exit_code"] =
      status.state() == v1::JobStatus::ENDED ? json(status.exit_code()) : json(nullptr);
  result["failure"] = printable(status.failure());
  return result;
}

}  // namespace tessera
