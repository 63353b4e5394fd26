#include "worker/trace_run.h"

#include <fmt/format.h>

#include <exception>
#include <new>
#include <utility>

#include "base/cancellation.h"
#include "base/error.h"
#include "base/monotonic.h"
#include "base/process_usage.h"
#include "proto/wire/pixels.h"
#include "proto/wire/scene_codec.h"

namespace tessera {

v1::Scene BuildRun::scene() const {
  auto scene =
      parse_scene({reinterpret_cast<const char*>(scene_bytes->data()), scene_bytes->size()});
  if (!scene) throw scene_error("the scene's bytes are no scene");
  return std::move(*scene);
}

TraceOutcome trace(std::shared_ptr<TraceRun> run) {
  TraceOutcome outcome;
  outcome.run = run;
  if (run->progress.cancelled) {
    outcome.cancelled = true;
    return outcome;
  }
  run->started = true;
  const Time began = thread_time();
  const Cancellation cancellation(run->job_dropped.get());
  try {
    const auto pixels = run->renderer->render(run->task, run->progress);
    if (!pixels) {
      outcome.cancelled = true;
      return outcome;
    }
    const PixelRect& rect = run->task.rect;
    const auto expected = static_cast<size_t>(rect.area()) * static_cast<size_t>(pixels->channels);
    if (pixels->values.size() != expected) {
      outcome.failure =
          fmt::format("the tracer gave {} values; expected {}", pixels->values.size(), expected);
      return outcome;
    }
    outcome.bands =
        encode_bands(pixels->values, rect.width(), rect.y0, run->compress, pixels->channels);
    v1::TileBand& last = outcome.bands.back();
    // Above 0, which would say that it is not known.
    last.set_trace_microseconds(1 + static_cast<uint64_t>((thread_time() - began).count() / 1000));
    for (const auto& [name, value] : pixels->counters) {
      (*last.mutable_counters()->mutable_values())[name] = value;
    }
  } catch (const WorkCancelled&) {
    outcome.bands.clear();
    outcome.cancelled = true;
  } catch (const std::bad_alloc&) {
    outcome.bands.clear();
    outcome.out_of_memory = true;
    outcome.failure = "there is no memory for it";
  } catch (const std::exception& error) {
    outcome.failure = error.what();
  }
  return outcome;
}

}  // namespace tessera
