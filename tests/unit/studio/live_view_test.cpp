#include "studio/live_view.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>

namespace tessera {
namespace {

using std::chrono::milliseconds;

ViewLook look(const std::string& digest, const std::string& settings = "") {
  return {digest, settings};
}

TEST(PassLadder, TheFirstPassIsAsFineAsCanBeHadAtOnce) {
  PassLadder ladder;
  const ViewGoal goal{960, 540, 64};
  // 2 million samples a second: in .025 s beside the overhead 50,000 pixels; a scale of 3 has
  // 57,600, one of 4 has 32,400.
  EXPECT_EQ(ladder.first(goal), (ViewPass{4, 1}));
  for (int i = 0; i < 20; ++i) ladder.note(goal, {1, 1}, 0.001, 0.010);
  EXPECT_EQ(ladder.first(goal), (ViewPass{1, 1}));
  for (int i = 0; i < 20; ++i) ladder.note(goal, {1, 1}, 0.001, 100);
  EXPECT_EQ(ladder.first(goal), (ViewPass{7, 1})) << "138 pixels; 8 would have 120, less than 128";
  EXPECT_EQ(ladder.first({4000, 100, 64}), (ViewPass{16, 1}));
}

TEST(PassLadder, LeadsToTheLastPass) {
  const ViewGoal goal{960, 540, 50};
  std::vector<ViewPass> passes{{8, 1}};
  while (const auto next = PassLadder::next(goal, passes.back())) passes.push_back(*next);
  EXPECT_EQ(passes, (std::vector<ViewPass>{{8, 1}, {1, 1}, {1, 4}, {1, 16}, {1, 50}}));
}

class LiveViewTest : public testing::Test {
 protected:
  LiveViewTest() {
    view_.set_goal({256, 128, 16}, now_);
    view_.set_look(look("a"), false, now_);
  }
  LiveView::Orders orders() { return view_.orders(now_); }
  /// Ends the running pass, as quick as can be.
  void end_pass() { view_.pass_done(view_.running()->serial, 0.001, 0.001); }

  LiveView view_{std::make_shared<uint32_t>(0)};
  Time now_ = std::chrono::seconds(100);
};

TEST_F(LiveViewTest, NothingIsTracedUntilAnotherSceneIsThere) {
  ASSERT_TRUE(orders().start);
  const uint32_t serial = view_.running()->serial;
  view_.forget_look();
  EXPECT_EQ(orders().interrupt, serial);
  view_.set_goal({256, 128, 4}, now_);
  view_.forget_look();
  EXPECT_FALSE(orders().start);
  view_.refresh();
  EXPECT_FALSE(orders().start);
  // The other one is shown at once, whatever the mode.
  view_.set_mode(LiveView::Mode::by_hand);
  view_.set_look(look("b"), false, now_);
  EXPECT_TRUE(orders().start);
}

TEST_F(LiveViewTest, PassesFollowUntilTheLast) {
  std::vector<uint32_t> samples;
  for (auto next = orders(); next.start; next = orders()) {
    samples.push_back(next.start->pass.samples);
    EXPECT_EQ(next.start->is_last, next.start->pass.samples == 16);
    end_pass();
  }
  EXPECT_EQ(samples, (std::vector<uint32_t>{1, 4, 16}));
  EXPECT_EQ(view_.state(), LiveView::State::done);
  EXPECT_FALSE(orders().start) << "nothing is traced twice";
}

TEST_F(LiveViewTest, TheSameLookStartsNothing) {
  orders();
  view_.set_look(look("a"), false, now_);
  const auto next = orders();
  EXPECT_FALSE(next.start || next.interrupt);
}

TEST_F(LiveViewTest, ANewerSceneReplacesALongPass) {
  const uint32_t first = orders().start->serial;
  view_.pass_done(first, 0.001, 10);
  const auto slow = orders().start;
  ASSERT_TRUE(slow);
  view_.set_look(look("b"), false, now_);
  const auto next = orders();
  EXPECT_EQ(next.interrupt, slow->serial);
  ASSERT_TRUE(next.start);
  EXPECT_GT(next.start->serial, slow->serial);
}

TEST_F(LiveViewTest, APassThatEndsSoonIsNotGivenUp) {
  const uint32_t first = orders().start->serial;
  view_.set_look(look("b"), false, now_);
  EXPECT_FALSE(orders().interrupt);
  EXPECT_LT(view_.deadline(), now_ + milliseconds(60)) << "it is looked at again, though it hangs";
  view_.pass_done(first, 0.001, 0.001);
  const auto next = orders();
  ASSERT_TRUE(next.start);
  EXPECT_EQ(next.start->pass.samples, 1u) << "of the newer scene";
}

TEST_F(LiveViewTest, APassThatHangsIsGivenUpAfterAll) {
  const uint32_t first = orders().start->serial;
  view_.set_look(look("b"), false, now_);
  orders();
  now_ = view_.deadline();
  const auto next = orders();
  EXPECT_EQ(next.interrupt, first);
  EXPECT_TRUE(next.start);
}

TEST_F(LiveViewTest, AResizedViewWaitsUntilItsSizeStays) {
  orders();
  end_pass();
  for (int width = 300; width < 310; ++width) {
    now_ += milliseconds(100);
    view_.set_goal({width, 128, 16}, now_);
    const auto next = orders();
    EXPECT_FALSE(next.start && next.start->pass.samples == 1);
  }
  now_ = view_.deadline();
  EXPECT_TRUE(orders().start);
}

TEST_F(LiveViewTest, WhileTheCameraMovesOnlyFirstPassesAreTraced) {
  orders();
  end_pass();
  view_.set_look(look("a", "camera 2"), true, now_);
  const auto first = orders();
  ASSERT_TRUE(first.start);
  view_.pass_done(first.start->serial, 0.001, 0.001);
  EXPECT_FALSE(orders().start);
  now_ = view_.deadline();
  const auto next = orders();
  ASSERT_TRUE(next.start);
  EXPECT_EQ(next.start->pass.samples, 4u);
}

TEST_F(LiveViewTest, ByHandAndOnSaveTextsWait) {
  orders();
  end_pass();
  view_.set_mode(LiveView::Mode::on_save);
  view_.set_look(look("b"), false, now_);
  EXPECT_FALSE(orders().start);
  view_.note_saved();
  EXPECT_TRUE(orders().start);
  view_.set_mode(LiveView::Mode::by_hand);
  view_.set_look(look("c"), false, now_);
  view_.note_saved();
  EXPECT_FALSE(orders().start);
  view_.refresh();
  now_ += std::chrono::seconds(1);
  EXPECT_TRUE(orders().start);
  view_.set_look(look("d"), false, now_, true);
  now_ += std::chrono::seconds(1);
  EXPECT_TRUE(orders().start) << "what was asked for before it was read waits no more";
}

TEST_F(LiveViewTest, StopsAndGoesOn) {
  const uint32_t first = orders().start->serial;
  view_.stop();
  EXPECT_EQ(orders().interrupt, first);
  EXPECT_FALSE(orders().start);
  view_.refresh();
  EXPECT_TRUE(orders().start);
  view_.pause();
  EXPECT_TRUE(orders().interrupt);
  view_.set_look(look("b"), false, now_);
  EXPECT_FALSE(orders().start) << "a paused view stays so";
  view_.refresh();
  EXPECT_TRUE(orders().start);
}

TEST_F(LiveViewTest, GoesOnFromTheLastPassThatEnded) {
  orders();
  end_pass();
  EXPECT_EQ(orders().start->pass.samples, 4u);
  view_.pause();
  orders();
  view_.refresh();
  EXPECT_EQ(orders().start->pass.samples, 4u) << "the pass that was given up";
  end_pass();
  EXPECT_EQ(orders().start->pass.samples, 16u);
  view_.pause();
  orders();
  view_.set_look(look("b"), false, now_);
  view_.refresh();
  EXPECT_EQ(orders().start->pass.samples, 1u) << "of another scene";
}

TEST_F(LiveViewTest, WhatFailedLateIsTriedAnewWhenItIsAskedFor) {
  orders();
  end_pass();
  view_.pass_failed(orders().start->serial);
  EXPECT_FALSE(orders().start);
  view_.refresh();
  EXPECT_EQ(orders().start->pass.samples, 1u);
}

TEST_F(LiveViewTest, WhatFailedIsTriedAgainWithAnotherScene) {
  view_.pass_failed(orders().start->serial);
  EXPECT_EQ(view_.state(), LiveView::State::failed);
  EXPECT_FALSE(orders().start);
  view_.set_look(look("b"), false, now_);
  EXPECT_TRUE(orders().start);
}

/// Thousands of schedules of keys, resizes, stops and passes that end late, early or never: what is
/// shown at the end is the last scene, whole, and pictures never go back.
TEST(StudioDesk, Ladder) {
  for (uint32_t seed = 1; seed <= 3000; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    const auto below = [&random](uint32_t bound) { return random() % bound; };
    LiveView view(std::make_shared<uint32_t>(0));
    Time now = std::chrono::seconds(1);
    int scene = 0, shown = -1, width = 200;
    std::optional<LiveView::Start> running;
    int of_running = -1;
    std::optional<ViewPass> last_pass;
    const auto act = [&] {
      const auto orders = view.orders(now);
      if (orders.interrupt) {
        ASSERT_TRUE(running);
        ASSERT_EQ(*orders.interrupt, running->serial);
        running.reset();
      }
      if (orders.start) {
        ASSERT_FALSE(running) << "one pass at a time";
        running = orders.start;
        of_running = scene;
      }
    };
    const auto finish = [&] {
      if (!running) return;
      ASSERT_GE(of_running, shown) << "no older picture after a newer one";
      shown = of_running;
      last_pass = running->pass;
      const uint32_t serial = running->serial;
      running.reset();
      view.pass_done(serial, 0.001 * below(20), 0.001 * below(200));
    };
    view.set_goal({width, 100, 16}, now);
    view.set_look(look("0"), false, now);
    for (int step = 0; step < 60; ++step) {
      now += milliseconds(below(120));
      switch (below(8)) {
        case 0:
        case 1:
          view.set_look(look(std::to_string(++scene)), below(2) == 0, now);
          break;
        case 2:
          width = 200 + static_cast<int>(below(3));
          view.set_goal({width, 100, 16}, now);
          break;
        case 3:
          below(2) == 0 ? view.stop() : view.pause();
          break;
        case 4:
          view.refresh();
          break;
        default:
          finish();
      }
      act();
      if (HasFatalFailure()) return;
    }
    view.refresh();
    for (int i = 0; i < 20; ++i) {
      now += std::chrono::seconds(1);
      act();
      finish();
      if (HasFatalFailure()) return;
    }
    EXPECT_EQ(shown, scene);
    EXPECT_EQ(last_pass, (ViewPass{1, 16}));
    EXPECT_EQ(view.state(), LiveView::State::done);
  }
}

}  // namespace
}  // namespace tessera
