#pragma once

#include <cstdio>
#include <string>

#include "base/monotonic.h"
#include "job/job.h"

namespace tessera {

enum class ProgressStyle {
  silent,
  lines,  ///< for pipes and logs: a line every 2 s; after 1 s where it is a tenth further
  bar,    ///< for terminals: one line that redraws itself
};

/// Shows how far a frame is. Used by one thread.
class ProgressDisplay {
 public:
  /// `stream` is not owned. `label` names the frame; may be empty.
  ProgressDisplay(ProgressStyle style, std::FILE* stream, std::string label,
                  Time now = monotonic_now());
  /// Takes the bar away.
  ~ProgressDisplay();
  ProgressDisplay(const ProgressDisplay&) = delete;
  ProgressDisplay& operator=(const ProgressDisplay&) = delete;

  void show(const JobProgress& progress, Time now = monotonic_now());

 private:
  bool is_due(const JobProgress& progress, Time now) const;

  ProgressStyle style_;
  std::FILE* stream_;
  std::string label_;
  Time last_shown_;
  int last_tenth_ = 0;
  bool bar_is_drawn_ = false;
};

/// What to do on `stream`: nothing if `quiet`, a bar on a terminal, lines elsewhere.
ProgressStyle progress_style(std::FILE* stream, bool quiet);

/// One progress line without its end, such as " 42 %  21/50 tiles  4 workers  ETA 1:23".
std::string progress_text(const JobProgress& progress);
/// That behind a label and a bar, "[=====>     ]", in at most so many columns: first the bar
/// becomes shorter, then the last parts of the text are left out.
std::string progress_bar(const JobProgress& progress, const std::string& label, size_t columns);

/// "0.42 s", "12.3 s", "2:05", "1:02:05".
std::string duration_text(double seconds);

}  // namespace tessera
