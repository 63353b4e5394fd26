#include "coordinator/web/chrome_trace.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

namespace tessera {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kOwnProcess = 1;  ///< workers are those after it

int64_t microseconds(double seconds) { return std::llround(seconds * 1e6); }

Json event(const std::string& name, const char* category, int process, size_t row, double begin,
           double end) {
  const int64_t start = microseconds(begin);
  return {{"name", name},
          {"cat", category},
          {"ph", "X"},
          {"ts", start},
          {"dur", std::max<int64_t>(0, microseconds(end) - start)},
          {"pid", process},
          {"tid", row}};
}

Json title(int process, const std::string& name) {
  return {{"name", "process_name"},
          {"ph", "M"},
          {"pid", process},
          {"tid", 0},
          {"args", {{"name", name}}}};
}

/// The first row that is free from then on: spans of one row do not overlap.
size_t take_row(std::vector<double>& busy_until, double begin, double end) {
  const auto free = std::find_if(busy_until.begin(), busy_until.end(),
                                 [begin](double until) { return until <= begin; });
  const auto row = static_cast<size_t>(free - busy_until.begin());
  if (free == busy_until.end()) busy_until.push_back(0);
  busy_until[row] = end;
  return row;
}

Json event_of(const FrameTrace::Span& span, int process, size_t row) {
  if (span.kind == FrameTrace::Kind::scene) {
    return event("scene", "scene", process, row, span.begin, span.end);
  }
  const bool wasted = span.kind == FrameTrace::Kind::wasted;
  const bool lost = span.kind == FrameTrace::Kind::lost;
  Json json = event(fmt::format("tile {}", span.tile),
                    lost     ? "lost"
                    : wasted ? "wasted"
                             : "tile",
                    process, row, span.begin, span.end);
  const PixelRect& rect = span.rect;
  json["args"] = {{"rect", fmt::format("{},{},{},{}", rect.x0, rect.y0, rect.x1, rect.y1)},
                  {"wasted", wasted || lost}};
  return json;
}

}  // namespace

std::string chrome_trace(const FrameTrace& trace, const std::string& name,
                         const std::vector<TracePhase>& phases) {
  Json events = Json::array();
  events.push_back(title(kOwnProcess, name));
  // Viewers count from zero.
  double zero = 0;
  for (const TracePhase& phase : phases) zero = std::min(zero, phase.begin);
  for (const TracePhase& phase : phases) {
    events.push_back(
        event(phase.name, "phase", kOwnProcess, 0, phase.begin - zero, phase.end - zero));
  }
  std::map<uint64_t, int> processes;
  for (const auto& [id, worker] : trace.workers) {
    const int process = kOwnProcess + 1 + static_cast<int>(processes.size());
    processes.emplace(id, process);
    events.push_back(title(process, worker));
  }
  std::vector<FrameTrace::Span> spans = trace.spans;
  std::sort(spans.begin(), spans.end(),
            [](const auto& a, const auto& b) { return a.begin < b.begin; });
  std::map<uint64_t, std::vector<double>> rows;
  for (FrameTrace::Span& span : spans) {
    span.begin -= zero;
    span.end -= zero;
    events.push_back(event_of(span, processes.at(span.worker),
                              take_row(rows[span.worker], span.begin, span.end)));
  }
  const Json json{{"displayTimeUnit", "ms"},
                  {"otherData", {{"name", name}, {"spans_left_out", trace.left_out}}},
                  {"traceEvents", std::move(events)}};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace tessera
