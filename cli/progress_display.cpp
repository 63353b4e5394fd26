#include "cli/progress_display.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "base/plural.h"
#include "cli/say.h"

namespace tessera {
namespace {

constexpr std::chrono::milliseconds kBarInterval{100};
constexpr std::chrono::seconds kLineInterval{2};
constexpr std::chrono::seconds kTenthInterval{1};  ///< no flood from frames that take no time

/// Of the terminal behind `stream`; much where it does not tell.
size_t columns_of(std::FILE* stream) {
  winsize size{};
  const bool told = ioctl(fileno(stream), TIOCGWINSZ, &size) == 0 && size.ws_col > 1;
  return told ? size.ws_col : 1000;
}

double done_share(const JobProgress& progress) {
  if (progress.tiles_total == 0) return 0;
  return static_cast<double>(progress.tiles_done) / static_cast<double>(progress.tiles_total);
}

}  // namespace

ProgressStyle progress_style(std::FILE* stream, bool quiet) {
  if (quiet) return ProgressStyle::silent;
  return isatty(fileno(stream)) ? ProgressStyle::bar : ProgressStyle::lines;
}

std::string duration_text(double seconds) {
  if (seconds < 60) return fmt::format("{:.{}f} s", seconds, seconds < 10 ? 2 : 1);
  const auto whole = std::llround(seconds);
  if (whole < 3600) return fmt::format("{}:{:02}", whole / 60, whole % 60);
  return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

std::string progress_text(const JobProgress& progress) {
  std::string text = fmt::format("{:3.0f} %", done_share(progress) * 100);
  if (progress.tiles_total > 0) {
    text += fmt::format("  {}/{} tiles", progress.tiles_done, progress.tiles_total);
  }
  if (!progress.waiting_for.empty()) return text + "  waiting for " + progress.waiting_for;
  if (progress.workers > 0) {
    text += "  " + counted(progress.workers, "worker");
  }
  if (progress.remaining_seconds >= 0 && progress.tiles_done < progress.tiles_total) {
    text += fmt::format("  ETA {}", duration_text(progress.remaining_seconds));
  }
  return text;
}

std::string progress_bar(const JobProgress& progress, const std::string& label, size_t columns) {
  constexpr size_t kBarWidth = 24, kLeastBarWidth = 4, kAroundBar = 3;
  std::string text = progress_text(progress);
  const size_t room = columns - std::min(columns, label.size() + text.size() + kAroundBar);
  if (room >= kLeastBarWidth) {
    const size_t width = std::min(room, kBarWidth);
    const auto filled = static_cast<size_t>(done_share(progress) * static_cast<double>(width));
    return fmt::format("{}[{:=<{}}{}{: <{}}] {}", label, "", filled, filled < width ? ">" : "", "",
                       filled < width ? width - filled - 1 : 0, text);
  }
  text = label + text;
  while (text.size() > columns && text.rfind("  ") != std::string::npos) {
    text.resize(text.rfind("  "));
  }
  return text.substr(0, columns);
}

ProgressDisplay::ProgressDisplay(ProgressStyle style, std::FILE* stream, std::string label,
                                 Time now)
    : style_(style), stream_(stream), label_(std::move(label)), last_shown_(now) {}

ProgressDisplay::~ProgressDisplay() {
  if (bar_is_drawn_) say(stream_, "\r\x1b[K");
}

bool ProgressDisplay::is_due(const JobProgress& progress, Time now) const {
  const Time since = now - last_shown_;
  if (style_ == ProgressStyle::silent) return false;
  if (style_ == ProgressStyle::bar) return since >= kBarInterval;
  const int tenth = static_cast<int>(done_share(progress) * 10);
  return since >= kLineInterval || (tenth > last_tenth_ && since >= kTenthInterval);
}

void ProgressDisplay::show(const JobProgress& progress, Time now) {
  if (!is_due(progress, now)) return;
  last_shown_ = now;
  last_tenth_ = static_cast<int>(done_share(progress) * 10);
  const bool bar = style_ == ProgressStyle::bar;
  if (bar) {
    // A longer one would wrap and be left behind; the texts are ASCII but for names of endpoints.
    say(stream_, "\r\x1b[K{}", progress_bar(progress, label_, columns_of(stream_) - 1));
    bar_is_drawn_ = true;
  } else {
    say(stream_, "{}{}\n", label_, progress_text(progress));
  }
  std::fflush(stream_);
}

}  // namespace tessera
