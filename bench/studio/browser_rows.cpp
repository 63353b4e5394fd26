#include <fmt/format.h>

#include <thread>
#include <vector>

#include "base/error.h"
#include "base/monotonic.h"
#include "base/temporary_folder.h"
#include "bench/error/statistics.h"
#include "bench/studio/bench_rows.h"
#include "bench/studio/bench_scenes.h"
#include "bench/studio/browser.h"

namespace tessera {
namespace {

constexpr std::chrono::milliseconds kBetweenKeys{200};
constexpr int kCtrl = 2;

std::vector<double> measures(Browser& browser, std::string_view name) {
  return browser.evaluate(
      fmt::format("performance.getEntriesByName('studio:{}').map((each) => each.duration)", name));
}

/// Types and takes back a digit in the open text, again and again.
void type_digits(Browser& browser, int keys) {
  for (int i = 0; i < keys; ++i) {
    browser.type(static_cast<char>('1' + i % 9));
    std::this_thread::sleep_for(kBetweenKeys);
    browser.press("Backspace", 8);
    std::this_thread::sleep_for(kBetweenKeys);
  }
}

void open(Browser& browser, const std::string& file) {
  browser.click(".panel-files [role=\"option\"]", file);
  browser.wait_until(fmt::format("globalThis.tesseraStudio.state().file === '{}'", file));
  browser.wait_until("globalThis.tesseraStudio.state().picture.serial > 0");
}

}  // namespace

void add_browser_rows(const StudioBench& bench) {
  const StudioProcess& studio = bench.studio;
  const int rounds = bench.options.rounds;
  const TemporaryFolder folder("tessera-browser");
  bench.options.begin("keys in the browser");
  Browser browser(bench.options.browser, folder.path(), bench.options.check);
  const Time begin = monotonic_now();
  browser.call("Page.navigate",
               {{"url", fmt::format("http://{}/#token={}", studio.address(), studio.token())}});
  browser.wait_until("globalThis.tesseraStudio?.state().connection === 'open'");
  bench.add({"page usable after opening", milliseconds_since(begin), "ms", 500});

  browser.evaluate(
      "void (globalThis.long = [], new PerformanceObserver((list) => list.getEntries().forEach("
      "(each) => long.push(each.duration))).observe({type: 'longtask'}))");
  open(browser, kEdited);
  browser.wait_until("globalThis.tesseraStudio.state().picture.final");
  browser.click(".cm-scroller");
  browser.press("End", 35, kCtrl);
  for (const char sign : std::string("nodes { shape { sphere { radius: .10")) browser.type(sign);
  // What was wrong while that was typed had no picture.
  browser.wait_until("globalThis.tesseraStudio.state().picture.final");
  browser.evaluate("void performance.clearMeasures()");
  type_digits(browser, 2 * rounds);
  const std::vector<double> pixels = measures(browser, "pixels");
  if (pixels.empty()) throw render_error("no key in the page led to pixels");
  bench.add({"page, key to first pixels (p50)",
             median(pixels),
             "ms",
             50,
             {},
             fmt::format("{} pictures", pixels.size())});
  bench.add({"page, key to first pixels (p95)", percentile(pixels, 0.95), "ms", 100});

  // Comments start no picture: the heavy one goes on beside the keys.
  open(browser, kHeavy);
  browser.click(".cm-scroller");
  browser.press("End", 35, kCtrl);
  browser.type('#');
  browser.evaluate("void (performance.clearMeasures(), globalThis.long.length = 0)");
  const auto busy = [&] {
    const nlohmann::json answer = browser.call("Performance.getMetrics");
    for (const nlohmann::json& each : answer["metrics"]) {
      if (each["name"] == "TaskDuration") return each["value"].get<double>();
    }
    return 0.0;
  };
  browser.call("Performance.enable");
  const double before = busy();
  type_digits(browser, 2 * rounds);
  const double work = (busy() - before) / (4 * rounds);
  const std::vector<double> glyphs = measures(browser, "key");
  bench.add(
      {"page, key to the end of its frame (p99)",
       percentile(glyphs, 0.99),
       "ms",
       {},
       {},
       fmt::format("p50 {:.1f}, {} keys, a heavy scene beside", median(glyphs), glyphs.size())});
  bench.add({"page, work of the thread that types, a key", 1000 * work, "ms", 16, {}, "mean"});
  const double longest = browser.evaluate("Math.max(0, ...globalThis.long)");
  bench.add({"page, longest task while typing", longest, "ms", 50, {}, "0: none of 50 ms"});
}

}  // namespace tessera
