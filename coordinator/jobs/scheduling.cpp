#include "coordinator/jobs/scheduling.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>
#include <utility>

#include "base/saturating_sum.h"

namespace tessera {
namespace {

/// Frames of one job at a time: the next begins when all tiles of the one before are given out.
constexpr size_t kMostFramesOfJob = 2;

bool takes_place(const OpenJob& job) { return !job.paused && !job.begun.empty(); }

uint64_t promised(std::span<const OpenJob> jobs) {
  uint64_t sum = 0;
  for (const OpenJob& job : jobs) {
    for (const BegunFrame& frame : job.begun) sum = saturating_sum(sum, frame.film_bytes);
  }
  return sum;
}

/// Whether its next frame may be begun beside those of the job that are.
bool wants_to_begin(const OpenJob& job) {
  return !job.paused && job.next && job.begun.size() < kMostFramesOfJob &&
         std::none_of(job.begun.begin(), job.begun.end(),
                      [](const BegunFrame& frame) { return frame.has_pending; });
}

/// What is refused takes nothing.
uint64_t needed_bytes(const OpenJob& job, const BeginLimits& limits) {
  return job.next->film_bytes > limits.film_bytes ? 0 : job.next->film_bytes;
}

/// Whether frames of it may be put aside for a job of that priority.
bool yields(const OpenJob& job, int32_t priority) { return job.paused || job.priority < priority; }

bool may_be_put_aside(const OpenJob& job) {
  return std::all_of(job.begun.begin(), job.begun.end(),
                     [](const BegunFrame& frame) { return frame.may_be_put_aside; });
}

/// Jobs that are begun, and what is planned with them.
class Planner {
 public:
  Planner(std::vector<OpenJob>& jobs, const BeginLimits& limits) : limits_(limits) {
    for (OpenJob& job : jobs) {
      if (!job.begun.empty()) begun_.push_back(&job);
      places_ += takes_place(job);
    }
    bytes_ = promised(jobs);
  }

  void spill_paused() {
    for (OpenJob* job : begun_) {
      if (!job->paused) continue;
      const std::vector<BegunFrame> frames = job->begun;
      for (const BegunFrame& frame : frames) {
        if (frame.tiles_out == 0 && frame.may_be_put_aside) put_aside(*job, frame);
      }
    }
  }

  void begin(OpenJob& job) {
    const uint64_t bytes = needed_bytes(job, limits_);
    std::vector<Victim> victims;
    uint64_t freed = 0;
    if (job.begun.empty() && !find_place(job, victims, freed)) return;
    if (!find_memory(job, bytes, victims, freed)) return;
    for (const Victim& victim : victims) put_aside(*victim.job, victim.frame);
    plan_.begin.push_back({job.id, job.next->frame});
    if (job.begun.empty()) {
      ++places_;
      begun_.push_back(&job);
    }
    bytes_ = saturating_sum(bytes_, bytes);
    job.begun.push_back({job.next->frame, bytes, 0, true, false});
    job.next.reset();
  }

  BeginPlan take() { return std::move(plan_); }

 private:
  struct Victim {
    OpenJob* job = nullptr;
    BegunFrame frame;
  };

  bool find_place(const OpenJob& job, std::vector<Victim>& victims, uint64_t& freed) {
    if (places_ < limits_.jobs) return true;
    OpenJob* least = nullptr;
    bool is_urgent = false;
    for (OpenJob* other : begun_) {
      if (!takes_place(*other) || other->priority >= job.priority) continue;
      is_urgent = true;
      if (!may_be_put_aside(*other)) continue;
      if (!least || std::pair(other->priority, tiles_out(*other)) <
                        std::pair(least->priority, tiles_out(*least))) {
        least = other;
      }
    }
    if (is_urgent && places_ < limits_.urgent_jobs) return true;
    if (!least) return false;
    for (const BegunFrame& frame : least->begun) {
      victims.push_back({least, frame});
      freed = saturating_sum(freed, frame.film_bytes);
    }
    return true;
  }

  bool find_memory(const OpenJob& job, uint64_t bytes, std::vector<Victim>& victims,
                   uint64_t freed) {
    const auto fits = [&] { return saturating_sum(bytes_ - freed, bytes) <= limits_.film_bytes; };
    if (fits()) return true;
    const size_t for_place = victims.size();
    std::vector<Victim> others;
    for (OpenJob* other : begun_) {
      if (other == &job || !yields(*other, job.priority)) continue;
      for (const BegunFrame& frame : other->begun) {
        const bool is_taken =
            std::any_of(victims.begin(), victims.end(), [&](const Victim& victim) {
              return victim.job == other && victim.frame.frame == frame.frame;
            });
        if (frame.may_be_put_aside && !is_taken) others.push_back({other, frame});
      }
    }
    std::stable_sort(others.begin(), others.end(), [](const Victim& a, const Victim& b) {
      const auto rank = [](const Victim& of) {
        return std::tuple(!of.job->paused, of.job->priority, of.frame.tiles_out);
      };
      return rank(a) < rank(b);
    });
    for (const Victim& victim : others) {
      if (fits()) break;
      freed = saturating_sum(freed, victim.frame.film_bytes);
      victims.push_back(victim);
    }
    if (!fits()) return false;
    // Small ones that came first may not be needed beside a large one that came after them.
    for (auto it = victims.begin() + static_cast<ptrdiff_t>(for_place); it != victims.end();) {
      freed -= it->frame.film_bytes;
      if (fits()) {
        it = victims.erase(it);
      } else {
        freed = saturating_sum(freed, (it++)->frame.film_bytes);
      }
    }
    return true;
  }

  void put_aside(OpenJob& job, const BegunFrame& frame) {
    const bool took_place = takes_place(job);
    std::erase_if(job.begun, [&](const BegunFrame& of) { return of.frame == frame.frame; });
    places_ -= took_place && job.begun.empty();
    bytes_ -= std::min(bytes_, frame.film_bytes);
    // It is begun another time.
    job.next.reset();
    plan_.put_aside.push_back({job.id, frame.frame});
  }

  BeginLimits limits_;
  std::vector<OpenJob*> begun_;
  size_t places_ = 0;
  uint64_t bytes_ = 0;
  BeginPlan plan_;
};

}  // namespace

size_t tiles_out(const OpenJob& job) {
  size_t count = 0;
  for (const BegunFrame& frame : job.begun) count += frame.tiles_out;
  return count;
}

BeginPlan plan_begin(std::vector<OpenJob> jobs, const BeginLimits& limits) {
  std::vector<OpenJob*> waiting;
  for (OpenJob& job : jobs) {
    if (wants_to_begin(job)) waiting.push_back(&job);
  }
  std::stable_sort(waiting.begin(), waiting.end(),
                   [](const OpenJob* a, const OpenJob* b) { return a->priority > b->priority; });
  Planner planner(jobs, limits);
  planner.spill_paused();
  for (OpenJob* job : waiting) {
    if (job->next) planner.begin(*job);
  }
  return planner.take();
}

std::string broken_rule(std::span<const OpenJob> jobs, const BeginLimits& limits) {
  const uint64_t all = promised(jobs);
  if (all > limits.film_bytes) {
    return fmt::format("films of {} bytes are promised; expected at most {}", all,
                       limits.film_bytes);
  }
  for (const OpenJob& job : jobs) {
    for (const BegunFrame& frame : job.begun) {
      if (job.paused && frame.tiles_out == 0 && frame.may_be_put_aside) {
        return fmt::format("job {} is paused and holds {} bytes", job.id, frame.film_bytes);
      }
    }
    if (!wants_to_begin(job)) continue;
    uint64_t fixed_bytes = 0;  // that nobody gives back for it
    size_t places = 0, fixed_places = 0;
    bool is_urgent = false;
    for (const OpenJob& other : jobs) {
      const bool gives = &other != &job && yields(other, job.priority);
      for (const BegunFrame& frame : other.begun) {
        if (!gives || !frame.may_be_put_aside) fixed_bytes += frame.film_bytes;
      }
      places += takes_place(other);
      fixed_places += takes_place(other) && !(gives && may_be_put_aside(other));
      is_urgent |= takes_place(other) && other.priority < job.priority;
    }
    const bool has_place = !job.begun.empty() || places < limits.jobs ||
                           (is_urgent && places < limits.urgent_jobs) || fixed_places < places;
    if (has_place && fixed_bytes + needed_bytes(job, limits) <= limits.film_bytes) {
      return fmt::format("job {} of priority {} fits and is not begun", job.id, job.priority);
    }
  }
  return "";
}

Wait wait_of(const OpenJob& job, std::span<const OpenJob> jobs, const BeginLimits& limits) {
  if (!wants_to_begin(job) || !job.begun.empty()) return {};
  Wait wait{.promised_bytes = promised(jobs)};
  const OpenJob* last = nullptr;
  size_t places = 0;
  for (const OpenJob& other : jobs) {
    if (!takes_place(other) || other.id == job.id) continue;
    ++places;
    if (!last || other.priority <= last->priority) last = &other;
  }
  if (last) wait.behind = last->id;
  const uint64_t bytes = saturating_sum(wait.promised_bytes, needed_bytes(job, limits));
  wait.what = bytes > limits.film_bytes ? Wait::For::memory
              : places >= limits.jobs   ? Wait::For::jobs
                                        : Wait::For::nothing;
  return wait;
}

bool is_needier(const Need& one, const Need& other) {
  return std::pair(-int64_t{one.priority}, one.share) <
         std::pair(-int64_t{other.priority}, other.share);
}

Forget scene_to_forget(std::span<const KnownScene> scenes, int32_t priority) {
  Forget forget;
  int32_t least = priority;
  for (const KnownScene& scene : scenes) {
    if (scene.priority >= priority) continue;
    forget.waits = true;
    if (scene.tiles_held > 0 || scene.priority >= least) continue;
    least = scene.priority;
    forget.frame = scene.frame;
  }
  forget.waits &= !forget.frame;
  return forget;
}

}  // namespace tessera
