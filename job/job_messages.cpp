#include "job/job_messages.h"

#include <array>
#include <utility>

#include "proto/wire/printable.h"

namespace tessera {
namespace {

using Total = uint64_t JobReport::*;
constexpr std::array<std::pair<const char*, Total>, 18> kTotals = {{
    {"tiles_total", &JobReport::tiles_total},
    {"tiles_done", &JobReport::tiles_done},
    {"tiles_restored", &JobReport::tiles_restored},
    {"retries", &JobReport::retries},
    {"speculative", &JobReport::speculative},
    {"filled", &JobReport::filled},
    {"split", &JobReport::split},
    {"moved", &JobReport::moved},
    {"duplicates", &JobReport::duplicates},
    {"mismatches", &JobReport::mismatches},
    {"verified", &JobReport::verified},
    {"unverified", &JobReport::unverified},
    {"liars", &JobReport::liars},
    {"retraced", &JobReport::retraced},
    {"workers_seen", &JobReport::workers_seen},
    {"workers_lost", &JobReport::workers_lost},
    {"bytes_scene", &JobReport::bytes_scene},
    {"bytes_results", &JobReport::bytes_results},
}};

}  // namespace

PixelRect rect_of(const v1::PixelRect& r) { return {r.x0(), r.y0(), r.x1(), r.y1()}; }

AovSet aovs_of(const v1::SubmitJob& request, uint32_t frame) {
  return AovSet(request.frames(static_cast<int>(frame)).settings().aovs());
}

uint64_t film_bytes_of(const v1::SubmitJob& request, uint32_t frame) {
  return film_bytes(rect_of(request.crop()), aovs_of(request, frame));
}

v1::PixelRect to_message(const PixelRect& rect) {
  v1::PixelRect message;
  message.set_x0(rect.x0);
  message.set_y0(rect.y0);
  message.set_x1(rect.x1);
  message.set_y1(rect.y1);
  return message;
}

v1::JobEnd to_message(const JobReport& report) {
  v1::JobEnd end;
  end.set_how(static_cast<v1::JobEnd::How>(report.end));
  end.set_exit_code(static_cast<uint32_t>(report.exit_code));
  end.set_failure(report.failure);
  // Each hole is a few bytes of a message that is bounded: past this many, the rest is in the film.
  constexpr size_t kMaxHoles = 10000;
  for (const PixelRect& hole : report.holes) {
    if (static_cast<size_t>(end.holes_size()) == kMaxHoles) break;
    *end.add_holes() = to_message(hole);
  }
  for (const auto& [name, value] : report.counters) {
    (*end.mutable_counters()->mutable_values())[name] = value;
  }
  for (const auto& [name, value] : report.build_counters) {
    (*end.mutable_build_counters()->mutable_values())[name] = value;
  }
  for (const auto& [name, member] : kTotals) {
    (*end.mutable_totals()->mutable_values())[name] = report.*member;
  }
  end.set_build_seconds(report.build_seconds);
  end.set_trace_seconds(report.trace_seconds);
  end.set_assemble_seconds(report.assemble_seconds);
  return end;
}

JobReport from_message(const v1::JobEnd& end) {
  JobReport report;
  report.end = end.how() == v1::JobEnd::DONE          ? JobReport::End::done
               : end.how() == v1::JobEnd::INTERRUPTED ? JobReport::End::interrupted
                                                      : JobReport::End::failed;
  report.exit_code = to_exit_code(end.exit_code());
  // A message may say what cannot be: only what is done has exit code 0.
  if (report.end == JobReport::End::interrupted) report.exit_code = ExitCode::interrupted;
  if (report.end == JobReport::End::failed && report.exit_code == ExitCode::done) {
    report.exit_code = ExitCode::render_failed;
  }
  if (report.exit_code != ExitCode::done && report.end == JobReport::End::done) {
    report.end = JobReport::End::failed;
  }
  report.failure = printable(end.failure());
  for (const v1::PixelRect& rect : end.holes()) {
    report.holes.push_back({rect.x0(), rect.y0(), rect.x1(), rect.y1()});
  }
  for (const auto& [name, value] : end.counters().values()) report.counters[name] = value;
  for (const auto& [name, value] : end.build_counters().values()) {
    report.build_counters[name] = value;
  }
  for (const auto& [name, member] : kTotals) {
    const auto it = end.totals().values().find(name);
    if (it != end.totals().values().end()) report.*member = it->second;
  }
  report.build_seconds = end.build_seconds();
  report.trace_seconds = end.trace_seconds();
  report.assemble_seconds = end.assemble_seconds();
  return report;
}

}  // namespace tessera
