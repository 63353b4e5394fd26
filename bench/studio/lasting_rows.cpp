#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "base/digest.h"
#include "base/error.h"
#include "base/process.h"
#include "base/program_folder.h"
#include "bench/error/statistics.h"
#include "bench/studio/bench_rows.h"
#include "bench/studio/bench_scenes.h"
#include "bench/studio/script.h"

namespace tessera {
namespace {

using Json = nlohmann::json;

void reconnect(const StudioBench& bench) {
  std::vector<double> taken;
  std::string resume;
  for (int i = 0; i < bench.options.rounds; ++i) {
    PageClient page(bench.studio);
    resume = page.receive({"welcome"}).value("id", "");
    page.say("open", {{"file", kLight}});
    const Json document = page.receive({"document"});
    Json have;
    const std::string text = document["text"];
    have[kLight] = {document["version"], sha256_hex(std::as_bytes(std::span(text)))};
    const Time begin = monotonic_now();
    PageClient again(bench.studio, {{"resume", resume}, {"have", have}});
    again.receive({"edited"});
    taken.push_back(milliseconds_since(begin));
  }
  bench.add({"reconnect, until the text is settled (p95)", percentile(taken, 0.95), "ms", 300});
}

double time_in_studio(const StudioBench& bench) {
  PageClient page(bench.studio);
  page.receive({"welcome"});
  const Time begin = monotonic_now();
  page.say("render",
           {{"file", kFull}, {"spec", {{"overrides", {{"spp", bench.options.samples}}}}}});
  const Json renders = page.receive({"renders"}, [](const Json& each) {
    return !each["list"].empty() && each["list"].back()["state"] == "done";
  });
  const double taken = to_seconds(monotonic_now() - begin);
  page.say("order", {{"job", renders["list"].back()["job"]}, {"what", "forget"}});
  page.receive({"renders"}, [](const Json& each) { return each["list"].empty(); });
  return taken;
}

double time_by_render(const StudioBench& bench) {
  const std::string output = bench.folder / "full.png";
  const Time begin = monotonic_now();
  const int process =
      start_process(program_path(), {"tessera", "render", bench.folder / kFull, "-o", output,
                                     "--spp", std::to_string(bench.options.samples), "--quiet"});
  if (wait_for_process(process) != 0) throw render_error("`tessera render` failed");
  return to_seconds(monotonic_now() - begin);
}

/// In turns; that of the studio is kept in memory, that of `tessera render` is written too.
void full_picture(const StudioBench& bench) {
  std::vector<double> ratios, ours, theirs;
  for (int i = 0; i < std::min(bench.options.rounds, 5); ++i) {
    ours.push_back(time_in_studio(bench));
    theirs.push_back(time_by_render(bench));
    ratios.push_back(ours.back() / theirs.back());
  }
  bench.add({"full picture / tessera render",
             median(ratios),
             "ratio",
             1.03,
             {},
             fmt::format("{:.2f} s, {:.2f} s", median(ours), median(theirs))});
}

/// Of the studio's own process, after a thousand edits and a hundred large pictures.
void edits_and_pictures(const StudioBench& bench) {
  const int edits = std::min(1000, 90 * bench.options.rounds),
            pictures = std::min(100, 9 * bench.options.rounds);
  PageClient page = show(bench.studio, kDragged);
  Script script(page, kDragged);
  script.take_place("radius: 0.");
  const auto work = [&](int keys, int views) {
    for (int i = 0; i < keys; ++i) {
      script.type(i);
      pause(6);  // the studio takes no more than 200 messages a second from a page
      // Of pixels there may be none, where the text makes the picture that is shown already.
      if (i % 20 == 0) {
        page.receive({"job"}, [&](const Json& each) {
          return of_version(script.version())(each) && each["state"] == "done";
        });
      }
      page.forget();
    }
    for (int i = 0; i < views; ++i) {
      Json view = view_of(kDragged, 2560 - i % 2, 1600);
      view["overrides"] = {{"spp", 1}};
      page.say("view", view);
      page.receive({"pixels"}, [&](const Json& each) {
        return each["is_last"] == true && each["width"] == 2560 - i % 2;
      });
      page.forget();
    }
    page.say("view", view_of(kDragged));
    page.receive({"pixels"}, [](const Json& each) {
      return each["is_last"] == true && each["width"] == kViewWidth;
    });
    pause(500);
  };
  work(20, 4);
  const auto before = static_cast<double>(resident_bytes_of(bench.studio.process()));
  work(edits, pictures);
  const auto after = static_cast<double>(resident_bytes_of(bench.studio.process()));
  bench.add(
      {fmt::format("memory after {} edits and {} pictures of 4 Mpx / before", edits, pictures),
       after / before,
       "ratio",
       1.1,
       {},
       fmt::format("{:.0f} MiB before", before / (1 << 20))});
}

double fresh_memory(const StudioBench& bench) {
  const StudioProcess fresh(bench.folder, bench.options.check);
  const PageClient page = show(fresh, kLight, true);
  return static_cast<double>(resident_bytes_of(fresh.process())) / (1 << 20);
}

void idle(const StudioBench& bench) {
  PageClient page = show(bench.studio, kLight, true);
  pause(2000);
  page.forget();
  const uint64_t before = nanoseconds_of(bench.studio.process());
  page.receive_within({}, std::chrono::seconds(bench.options.idle_seconds));
  const auto ran = static_cast<double>(nanoseconds_of(bench.studio.process()) - before);
  bench.add({"idle, of a core", ran * 1e-9 / bench.options.idle_seconds * 100, "%", 0.5});
  const auto others = std::count_if(
      page.kept().begin(), page.kept().end(),
      [](const auto& message) { return message.first != "metrics" && message.first != "workers"; });
  bench.add({"idle, messages but metrics", static_cast<double>(others),
             fmt::format("in {} s", bench.options.idle_seconds), 0});
  bench.add({"memory of a studio just started", fresh_memory(bench), "MiB", 60});
}

}  // namespace

void add_lasting_rows(const StudioBench& bench) {
  bench.options.begin("reconnecting");
  reconnect(bench);
  bench.options.begin("full pictures");
  full_picture(bench);
  bench.options.begin("memory after edits and pictures");
  edits_and_pictures(bench);
  bench.options.begin("idling");
  idle(bench);
}

}  // namespace tessera
