#include "worker/render_service.h"

#include <gtest/gtest.h>

#include <atomic>
#include <set>
#include <stdexcept>
#include <thread>

#include "base/error.h"
#include "base/monotonic.h"
#include "base/parallel.h"
#include "tests/farm/fake_renderer.h"

namespace tessera {
namespace {

using testing::FakeRenderer;

class Waiter {
 public:
  void wake() {
    ++count_;
    count_.notify_one();
  }
  /// Blocks until woken more often than it was asked.
  void wait() {
    count_.wait(asked_);
    ++asked_;
  }

 private:
  std::atomic<int> count_{0};
  int asked_ = 0;
};

std::shared_ptr<TraceRun> run_of(std::shared_ptr<const TileRenderer> renderer, int side = 8) {
  auto run = std::make_shared<TraceRun>();
  run->task.rect = {0, 0, side, side};
  run->renderer = std::move(renderer);
  return run;
}

TEST(RenderService, TracesEachRunOnce) {
  Waiter waiter;
  RenderService service(testing::make_fake_renderer, 3, [&] { waiter.wake(); });
  std::set<TraceRun*> runs;
  for (int i = 0; i < 50; ++i) {
    const auto run = run_of(std::make_shared<FakeRenderer>(1));
    runs.insert(run.get());
    service.trace(run);
  }
  while (!runs.empty()) {
    auto outcome = service.take_traced();
    if (!outcome) continue;
    EXPECT_EQ(runs.erase(outcome->run.get()), 1u);
    EXPECT_TRUE(outcome->run->started);
    EXPECT_EQ(outcome->bands.size(), 1u);
  }
  EXPECT_FALSE(service.take_traced());
}

TEST(RenderService, TellsOfTilesTogetherWhileThereIsEnoughToDo) {
  constexpr Time kJustNow{0}, kLongAgo = std::chrono::seconds(1);
  EXPECT_TRUE(RenderService::is_worth_telling(0, 1, kJustNow));
  EXPECT_TRUE(RenderService::is_worth_telling(1, 1, kJustNow)) << "the next must come in time";
  EXPECT_FALSE(RenderService::is_worth_telling(2, 1, kJustNow));
  EXPECT_TRUE(RenderService::is_worth_telling(2, 1, kLongAgo));
  EXPECT_TRUE(RenderService::is_worth_telling(4, 8, kJustNow));
  EXPECT_FALSE(RenderService::is_worth_telling(5, 8, kJustNow));
}

TEST(RenderService, BuildsAndSaysWhyItCouldNot) {
  Waiter waiter;
  int calls = 0;
  const auto factory = [&](const v1::Scene&, const BlobStore&, const v1::FrameSettings&,
                           int threads) -> std::shared_ptr<const TileRenderer> {
    EXPECT_EQ(threads, 2);
    switch (++calls) {
      case 1:
        return std::make_shared<FakeRenderer>(1);
      case 2:
        throw scene_error("bad scene");
      case 3:
        throw std::bad_alloc();
      default:
        return nullptr;
    }
  };
  RenderService service(factory, 2, [&] { waiter.wake(); });
  std::vector<BuildOutcome> outcomes;
  for (uint64_t job = 1; job <= 4; ++job) {
    auto run = std::make_shared<BuildRun>();
    run->job = job;
    run->scene_bytes = make_blob({});
    service.build(run);
    waiter.wait();
    outcomes.push_back(*service.take_built());
    EXPECT_EQ(outcomes.back().job, job);
  }
  EXPECT_TRUE(outcomes[0].renderer);
  EXPECT_EQ(outcomes[1].failure, "bad scene");
  EXPECT_EQ(outcomes[1].cause, v1::SceneFailed::BAD_SCENE);
  EXPECT_EQ(outcomes[2].cause, v1::SceneFailed::OUT_OF_RESOURCES);
  EXPECT_FALSE(outcomes[3].renderer);
  EXPECT_NE(outcomes[3].failure, "");
}

TEST(RenderService, SaysWhereTheBytesAreNoScene) {
  Waiter waiter;
  const auto factory = [](const v1::Scene&, const BlobStore&, const v1::FrameSettings&,
                          int) -> std::shared_ptr<const TileRenderer> {
    return std::make_shared<FakeRenderer>(1);
  };
  RenderService service(factory, 1, [&] { waiter.wake(); });
  const auto run = std::make_shared<BuildRun>();
  run->scene_bytes = make_blob(std::vector(3, std::byte{0xff}));
  service.build(run);
  waiter.wait();
  const auto outcome = service.take_built();
  EXPECT_FALSE(outcome->renderer);
  EXPECT_EQ(outcome->cause, v1::SceneFailed::BAD_SCENE);
  EXPECT_EQ(outcome->failure, "the scene's bytes are no scene");
}

TEST(RenderService, DropsABuildAndBeginsTheNext) {
  Waiter waiter;
  std::atomic<int> pieces{0};
  const auto factory = [&](const v1::Scene&, const BlobStore&, const v1::FrameSettings& frame,
                           int) -> std::shared_ptr<const TileRenderer> {
    // Without end, unless it is dropped.
    if (frame.seed() == 1) for_each_parallel(size_t{1} << 40, 1, [&](size_t) { ++pieces; });
    return std::make_shared<FakeRenderer>(frame.seed());
  };
  RenderService service(factory, 1, [&] { waiter.wake(); });
  const auto dropped = std::make_shared<std::atomic<bool>>(false);
  for (const uint32_t seed : {1u, 2u}) {
    auto run = std::make_shared<BuildRun>();
    run->job = seed;
    run->scene_bytes = make_blob({});
    run->frame.set_seed(seed);
    if (seed == 1) run->dropped = dropped;
    service.build(run);
  }
  while (pieces == 0) std::this_thread::yield();
  *dropped = true;
  waiter.wait();
  const auto first = service.take_built();
  EXPECT_TRUE(first->dropped);
  EXPECT_FALSE(first->renderer);
  EXPECT_EQ(first->failure, "");
  waiter.wait();
  EXPECT_TRUE(service.take_built()->renderer);
}

TEST(Trace, DropsWhatIsBuiltWhenItIsHit) {
  class Building : public TileRenderer {
    std::optional<TilePixels> render(const RenderTask&, TileProgress&) const override {
      for_each_parallel(1, 1, [](size_t) {});
      return TilePixels{};
    }
    CounterMap build_counters() const override { return {}; }
  };
  const auto run = run_of(std::make_shared<Building>());
  run->job_dropped = std::make_shared<const std::atomic<bool>>(true);
  const auto outcome = trace(run);
  EXPECT_TRUE(outcome.cancelled);
  EXPECT_EQ(outcome.failure, "");
}

TEST(Trace, PassesOnWhatATracerThrows) {
  class Throwing : public TileRenderer {
    std::optional<TilePixels> render(const RenderTask&, TileProgress&) const override {
      throw std::runtime_error("broken");
    }
    CounterMap build_counters() const override { return {}; }
  };
  EXPECT_EQ(trace(run_of(std::make_shared<Throwing>())).failure, "broken");
}

TEST(Trace, TellsThatThereIsNoMemory) {
  class Starving : public TileRenderer {
    std::optional<TilePixels> render(const RenderTask&, TileProgress&) const override {
      throw std::bad_alloc();
    }
    CounterMap build_counters() const override { return {}; }
  };
  const auto outcome = trace(run_of(std::make_shared<Starving>()));
  EXPECT_TRUE(outcome.out_of_memory);
  EXPECT_NE(outcome.failure, "");
}

TEST(Trace, DoesNotStartWhatIsCancelled) {
  const auto run = run_of(std::make_shared<FakeRenderer>(1));
  run->progress.cancelled = true;
  EXPECT_TRUE(trace(run).cancelled);
  EXPECT_FALSE(run->started);
}

TEST(Trace, RefusesPixelsOfAnotherSize) {
  class Short : public TileRenderer {
    std::optional<TilePixels> render(const RenderTask&, TileProgress&) const override {
      return TilePixels{};
    }
    CounterMap build_counters() const override { return {}; }
  };
  const auto outcome = trace(run_of(std::make_shared<Short>()));
  EXPECT_NE(outcome.failure, "");
  EXPECT_TRUE(outcome.bands.empty());
}

}  // namespace
}  // namespace tessera
