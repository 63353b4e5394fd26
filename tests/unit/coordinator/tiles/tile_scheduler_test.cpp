#include "coordinator/tiles/tile_scheduler.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tessera {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr WorkerId kA = 1, kB = 2, kC = 3, kD = 4;

class TileSchedulerTest : public ::testing::Test {
 protected:
  TileScheduler make(size_t tiles, std::initializer_list<WorkerId> workers = {kA, kB, kC}) const {
    TileScheduler scheduler(tiles, TileRules{});
    for (const WorkerId worker : workers) scheduler.join(worker);
    return scheduler;
  }
};

TEST_F(TileSchedulerTest, GivesEachTileOnceAndEnds) {
  TileScheduler scheduler = make(3);
  std::vector<Lease> leases;
  for (const WorkerId worker : {kA, kB, kA}) leases.push_back(*scheduler.assign(worker, {}));
  EXPECT_EQ(leases[0].tile, 0u);
  EXPECT_EQ(leases[1].tile, 1u);
  EXPECT_EQ(leases[2].tile, 2u);
  EXPECT_FALSE(scheduler.assign(kC, {}));
  EXPECT_EQ(scheduler.held_by(kA), 2u);
  for (const Lease& lease : leases) {
    EXPECT_FALSE(scheduler.finished());
    EXPECT_EQ(TileScheduler::tile_of(lease.id), lease.tile);
    EXPECT_THAT(scheduler.complete(lease.tile, lease.id, {}).cancelled, IsEmpty());
  }
  EXPECT_TRUE(scheduler.finished());
  EXPECT_EQ(scheduler.retries(), 0u);
}

TEST_F(TileSchedulerTest, LetsMoreTilesWaitWhileTheyComeBackAtOnce) {
  TileScheduler scheduler = make(100, {kA, kB});
  EXPECT_EQ(scheduler.depth(1), 2u);
  EXPECT_EQ(scheduler.depth(4), 6u) << "one for each thread, and some";
  const auto finish_one_after = [&](Time took) {
    const Lease lease = *scheduler.assign(kA, {});
    scheduler.complete(lease.tile, lease.id, took);
  };
  finish_one_after(milliseconds(5));
  EXPECT_EQ(scheduler.depth(1), 24u) << "of 99 tiles, to each of two";
  for (int i = 0; i < 79; ++i) finish_one_after(milliseconds(5));
  EXPECT_EQ(scheduler.depth(1), 5u) << "fewer as it ends";
  finish_one_after(seconds(10));
  EXPECT_EQ(scheduler.depth(1), 2u) << "slow ones do not wait at one worker";
}

TEST_F(TileSchedulerTest, KnowsNobodyWhoDidNotJoin) {
  TileScheduler scheduler = make(1, {});
  EXPECT_FALSE(scheduler.assign(kA, {}));
}

TEST_F(TileSchedulerTest, GivesTheTilesOfALostWorkerToOthersFirst) {
  TileScheduler scheduler = make(4);
  scheduler.assign(kA, {});
  EXPECT_THAT(scheduler.leave(kA, LossCause::vanished, {}).blamed, IsEmpty());
  const auto lease = scheduler.assign(kB, {});
  EXPECT_EQ(lease->tile, 0u);
  EXPECT_EQ(scheduler.retries(), 1u);
  EXPECT_FALSE(scheduler.assign(kA, {}));
}

TEST_F(TileSchedulerTest, RenewsALeaseForProgressOnly) {
  TileScheduler scheduler = make(1, {kA});
  const Lease lease = *scheduler.assign(kA, {});
  SchedulerEvents events;
  for (int second = 1; second <= 30; ++second) {
    scheduler.report(kA, {{lease.id, static_cast<uint64_t>(second), true}}, seconds(second),
                     events);
    EXPECT_THAT(scheduler.expire(seconds(second)).blamed, IsEmpty());
  }
  // The heart beats on, the tile does not.
  for (int second = 31; second < 40; ++second) {
    scheduler.report(kA, {{lease.id, 30, true}}, seconds(second), events);
    EXPECT_THAT(scheduler.expire(seconds(second)).blamed, IsEmpty()) << second;
  }
  EXPECT_THAT(scheduler.expire(seconds(40)).blamed, ElementsAre(kA));
  EXPECT_EQ(scheduler.held_by(kA), 0u);
}

TEST_F(TileSchedulerTest, ATileThatWaitsItsTurnIsNotBlamed) {
  TileScheduler scheduler = make(2, {kA});
  const Lease first = *scheduler.assign(kA, {}), second = *scheduler.assign(kA, {});
  SchedulerEvents events;
  for (int i = 1; i <= 30; ++i) {
    scheduler.report(kA, {{first.id, static_cast<uint64_t>(i), true}, {second.id, 0, false}},
                     seconds(i), events);
    EXPECT_THAT(scheduler.expire(seconds(i)).blamed, IsEmpty());
  }
  EXPECT_EQ(scheduler.held_by(kA), 2u);
  // Both stop: only the one that runs is to blame.
  EXPECT_THAT(scheduler.expire(seconds(41)).blamed, ElementsAre(kA));
  EXPECT_EQ(scheduler.held_by(kA), 0u);
}

TEST_F(TileSchedulerTest, WhatAHeartbeatDoesNotListWasLostOnTheWay) {
  TileScheduler scheduler = make(1, {kA, kB});
  scheduler.assign(kA, {});
  SchedulerEvents events;
  scheduler.report(kA, {}, seconds(1), events);
  EXPECT_EQ(scheduler.held_by(kA), 1u);
  scheduler.report(kA, {}, seconds(3), events);
  EXPECT_EQ(scheduler.held_by(kA), 0u);
  EXPECT_THAT(events.blamed, IsEmpty());
  EXPECT_TRUE(scheduler.assign(kB, seconds(3)));
}

TEST_F(TileSchedulerTest, CountsForeignTilesAndCancelsTheFinishedOnes) {
  TileScheduler scheduler = make(2, {kA, kB});
  const Lease old = *scheduler.assign(kA, {});
  scheduler.assign(kA, {});
  scheduler.leave(kA, LossCause::vanished, {});
  scheduler.join(kA);
  const Lease fresh = *scheduler.assign(kB, {});
  ASSERT_EQ(fresh.tile, 1u);
  SchedulerEvents events;
  EXPECT_EQ(scheduler.report(kA, {{old.id, 5, true}}, {}, events), 1u);
  EXPECT_THAT(events.unwanted, IsEmpty());
  scheduler.complete(0, 999, {});
  EXPECT_EQ(scheduler.report(kA, {{old.id, 5, true}}, {}, events), 1u);
  EXPECT_THAT(events.unwanted, ElementsAre(old.id));
  EXPECT_THAT(events.cancelled, IsEmpty()) << "it was dropped before";
}

TEST_F(TileSchedulerTest, LeasesOfTilesThatThereAreNoneOfAreUnwanted) {
  TileScheduler scheduler = make(2, {kA});
  SchedulerEvents events;
  const LeaseId made_up = uint64_t{5} << 32 | 0xfffff;
  EXPECT_EQ(scheduler.report(kA, {{made_up, 0, false}}, {}, events), 1u);
  EXPECT_THAT(events.unwanted, ElementsAre(made_up));
  EXPECT_THAT(events.cancelled, IsEmpty());
}

TEST_F(TileSchedulerTest, AdoptsWholeTilesOfCoordinatorsBeforeAlone) {
  constexpr int kTagShift = 52;
  const auto accepts = [&](uint64_t tag, TilePiece piece, bool ours, bool adopts = true) {
    TileRules rules;
    rules.adopts = adopts;
    rules.opening = std::string(7, 'x') + '\x03';  // its tag: the uppermost 12 bits
    return TileScheduler(2, rules).accepts(tag << kTagShift | piece.packed(), ours, kA);
  };
  constexpr uint64_t kOurs = 0x037;
  EXPECT_TRUE(accepts(2, {1}, false));
  EXPECT_TRUE(accepts(1, {0}, false));
  EXPECT_FALSE(accepts(kOurs, {1}, true)) << "our own, which we have not given";
  EXPECT_FALSE(accepts(kOurs, {1}, false)) << "one that cannot be told from our own";
  EXPECT_FALSE(accepts(2, {1}, true)) << "said to be our own, which it is not";
  EXPECT_FALSE(accepts(2, {2}, false)) << "no tile of ours";
  EXPECT_FALSE(accepts(2, {1, 0, 2}, false)) << "a part";
  EXPECT_FALSE(accepts(2, {1}, false, false)) << "of a frame that nobody had before";
}

TEST_F(TileSchedulerTest, CopiesAStragglerOnceWhenTheQueueIsEmpty) {
  TileScheduler scheduler = make(3);
  const Lease slow = *scheduler.assign(kA, {});
  const Lease quick = *scheduler.assign(kB, {});
  const Lease other = *scheduler.assign(kC, {});
  scheduler.complete(quick.tile, quick.id, seconds(1));
  SchedulerEvents none;
  const auto at_end = [&](WorkerId worker, Time now) {
    EXPECT_FALSE(scheduler.assign(worker, now));
    return scheduler.assign_at_end(worker, now, false, true, none);
  };
  EXPECT_FALSE(at_end(kB, milliseconds(1400)));
  const auto copy = at_end(kB, milliseconds(1600));
  ASSERT_TRUE(copy);
  EXPECT_TRUE(copy->speculative);
  EXPECT_EQ(copy->tile, slow.tile);
  EXPECT_EQ(scheduler.speculative(), 1u);
  EXPECT_EQ(scheduler.retries(), 0u);
  // Not a third time, and nobody gets a copy of their own.
  EXPECT_EQ(at_end(kB, milliseconds(1600))->tile, other.tile);
  EXPECT_FALSE(at_end(kC, seconds(100)));
  const auto events = scheduler.complete(slow.tile, copy->id, seconds(2));
  ASSERT_EQ(events.cancelled.size(), 1u);
  EXPECT_EQ(events.cancelled[0].id, slow.id);
  EXPECT_EQ(scheduler.held_by(kA), 0u);
}

TEST_F(TileSchedulerTest, ASuspectGetsNothingAndOthersGetCopiesOfItsTiles) {
  TileScheduler scheduler = make(2);
  scheduler.assign(kA, {});
  scheduler.set_suspect(kA, true);
  EXPECT_FALSE(scheduler.assign(kA, {}));
  EXPECT_EQ(scheduler.assign(kB, {})->tile, 0u);
  EXPECT_EQ(scheduler.assign(kB, {})->tile, 1u);
  EXPECT_EQ(scheduler.speculative(), 1u);
  scheduler.set_suspect(kA, false);
}

TEST_F(TileSchedulerTest, GivesATileUpAfterThreeWorkersFailedIt) {
  TileScheduler scheduler = make(1, {kA, kB, kC, kD});
  for (const WorkerId worker : {kA, kB}) {
    const Lease lease = *scheduler.assign(worker, {});
    const auto events = scheduler.fail(lease.id, worker, {});
    EXPECT_THAT(events.blamed, ElementsAre(worker));
    EXPECT_THAT(events.given_up, IsEmpty());
    EXPECT_FALSE(scheduler.assign(worker, {})) << "others have not tried it";
  }
  const Lease lease = *scheduler.assign(kC, {});
  EXPECT_THAT(scheduler.fail(lease.id, kC, {}).given_up, ElementsAre(0u));
  EXPECT_TRUE(scheduler.finished());
  EXPECT_FALSE(scheduler.assign(kD, {}));
}

TEST_F(TileSchedulerTest, TheOnlyWorkerTriesThreeTimes) {
  TileScheduler scheduler = make(1, {kA});
  for (int i = 0; i < 3; ++i) {
    const auto lease = scheduler.assign(kA, {});
    ASSERT_TRUE(lease);
    scheduler.fail(lease->id, kA, {});
  }
  EXPECT_TRUE(scheduler.finished());
}

TEST_F(TileSchedulerTest, AFailureIsRetriedByTheSameOneIfTheOthersAreStuck) {
  TileScheduler scheduler = make(1, {kA, kB});
  scheduler.fail(scheduler.assign(kA, {})->id, kA, {});
  EXPECT_FALSE(scheduler.assign(kA, seconds(9)));
  EXPECT_TRUE(scheduler.assign(kA, seconds(10)));
}

TEST_F(TileSchedulerTest, ACrashBlamesAllThatItHeldAndTheyRunAloneThen) {
  TileScheduler scheduler = make(4, {kA, kB});
  scheduler.assign(kA, {});
  scheduler.assign(kA, {});
  EXPECT_THAT(scheduler.leave(kA, LossCause::crashed, {}).blamed, ElementsAre(kA, kA));
  const Lease alone = *scheduler.assign(kB, {});
  EXPECT_LT(alone.tile, 2u);
  EXPECT_FALSE(scheduler.assign(kB, {}));
  scheduler.complete(alone.tile, alone.id, {});
  // With a sound one in hand, the other suspect has to wait.
  const Lease second = *scheduler.assign(kB, {});
  EXPECT_LT(second.tile, 2u);
  scheduler.complete(second.tile, second.id, {});
  EXPECT_GE(scheduler.assign(kB, {})->tile, 2u);
  EXPECT_GE(scheduler.assign(kB, {})->tile, 2u);
}

TEST_F(TileSchedulerTest, WorkersThatVanishCountOnlyInTheLongRunAndIfTheyStayAway) {
  TileScheduler scheduler = make(1, {});
  for (int round = 0; round < 100; ++round) {
    scheduler.join(kA);
    ASSERT_TRUE(scheduler.assign(kA, {})) << round;
    EXPECT_THAT(scheduler.leave(kA, LossCause::vanished, {}).given_up, IsEmpty());
  }
  SchedulerEvents events;
  for (WorkerId worker = 100; !scheduler.finished(); ++worker) {
    ASSERT_LT(worker, 120u);
    scheduler.join(worker);
    ASSERT_TRUE(scheduler.assign(worker, {}));
    events = scheduler.leave(worker, LossCause::vanished, {});
  }
  EXPECT_THAT(events.given_up, ElementsAre(0u));
}

TEST_F(TileSchedulerTest, AResultForATileGivenUpIsStillWelcome) {
  TileScheduler scheduler = make(2, {kA});
  LeaseId last = 0;
  for (int i = 0; i < 3; ++i) {
    last = scheduler.assign(kA, {})->id;
    ASSERT_EQ(TileScheduler::tile_of(last), 0u);
    scheduler.fail(last, kA, {});
  }
  scheduler.complete(0, last, {});
  EXPECT_FALSE(scheduler.finished());
  const Lease lease = *scheduler.assign(kA, {});
  scheduler.complete(1, lease.id, {});
  EXPECT_TRUE(scheduler.finished());
}

TEST_F(TileSchedulerTest, IgnoresFailuresOfLeasesOfOthers) {
  TileScheduler scheduler = make(1, {kA, kB});
  const Lease lease = *scheduler.assign(kA, {});
  EXPECT_THAT(scheduler.fail(lease.id, kB, {}).blamed, IsEmpty());
  EXPECT_THAT(scheduler.fail(12345, kA, {}).blamed, IsEmpty());
  EXPECT_EQ(scheduler.held_by(kA), 1u);
}

/// Four tiles of 8x8 pixels that take 100 ms each, and workers of one thread.
class EndOfQueue : public ::testing::Test {
 protected:
  EndOfQueue() {
    for (const WorkerId worker : {kA, kB, kC, kD}) scheduler.join(worker, 1);
  }
  void note_costs() {
    for (uint32_t tile = 0; tile < 4; ++tile) scheduler.costs().note(tile, 0.1);
  }
  /// Each traces one and has one waiting.
  std::vector<Lease> give_to_two() {
    std::vector<Lease> held;
    for (const WorkerId worker : {kA, kB, kA, kB}) held.push_back(*scheduler.assign(worker, now));
    note_costs();
    return held;
  }
  std::optional<Lease> take(WorkerId worker) {
    events = {};
    return scheduler.assign_at_end(worker, now, false, true, events);
  }
  Time now = seconds(1);
  TileScheduler scheduler{
      {{0, 0, 8, 8}, {8, 0, 16, 8}, {0, 8, 8, 16}, {8, 8, 16, 16}}, 8, TileRules{}};
  SchedulerEvents events;
};

TEST_F(EndOfQueue, WhatWaitsIsSplitForIdleWorkers) {
  const std::vector<Lease> held = give_to_two();
  ASSERT_FALSE(scheduler.has_pending());
  const Lease part = *take(kC);
  ASSERT_TRUE(events.recalled);
  EXPECT_EQ(events.recalled->id, held[2].id);
  EXPECT_EQ(part.tile, held[2].tile);
  EXPECT_EQ(part.piece().parts, 4u);
  EXPECT_EQ(part.piece().rect({0, 0, 8, 8}), (PixelRect{0, 0, 8, 2}));
  EXPECT_EQ(scheduler.split_tiles(), 1u);
  // The rest of it is for whoever has room.
  EXPECT_TRUE(scheduler.has_pending());
  std::vector<Lease> parts{part};
  for (const WorkerId worker : {kD, kC, kA}) parts.push_back(*scheduler.assign(worker, now));
  for (uint32_t i = 0; i < 4; ++i) {
    EXPECT_EQ(parts[i].piece(), (TilePiece{held[2].tile, i, 4}));
    EXPECT_FALSE(parts[i].again);
  }
  EXPECT_FALSE(scheduler.has_pending());
  for (const Lease& lease : parts) {
    EXPECT_THAT(scheduler.complete_part(lease.id).cancelled, IsEmpty());
    EXPECT_FALSE(scheduler.has_pending());
  }
  scheduler.complete(held[2].tile, parts[3].id, now);
  for (const size_t i : {0, 1, 3}) scheduler.complete(held[i].tile, held[i].id, now);
  EXPECT_TRUE(scheduler.finished());
  EXPECT_EQ(scheduler.retries(), 0u);
}

TEST_F(EndOfQueue, ALastTileIsSplitWhereMoreThanOneIsIdle) {
  for (const WorkerId worker : {kA, kA, kA}) scheduler.assign(worker, now);
  note_costs();
  const Lease part = *scheduler.assign(kB, now);
  EXPECT_EQ(part.piece(), (TilePiece{3, 0, 6}));  // two for each of three
  EXPECT_EQ(scheduler.assign(kC, now)->piece(), (TilePiece{3, 1, 6}));
}

TEST_F(EndOfQueue, WhoHadBegunMayCompleteItAndThePartsAreCancelled) {
  const std::vector<Lease> held = give_to_two();
  const Lease part = *take(kC);
  // Its worker had begun with it all the same.
  const auto done = scheduler.complete(held[2].tile, held[2].id, now);
  ASSERT_EQ(done.cancelled.size(), 1u);
  EXPECT_EQ(done.cancelled[0].id, part.id);
  EXPECT_FALSE(scheduler.has_pending());
}

TEST_F(EndOfQueue, ATileThatFailsInPartsIsWholeAgain) {
  const std::vector<Lease> held = give_to_two();
  const Lease part = *take(kC);
  const Lease other = *scheduler.assign(kD, now);
  const auto failed = scheduler.fail(part.id, kC, now);
  EXPECT_THAT(failed.blamed, ElementsAre(kC));
  ASSERT_EQ(failed.cancelled.size(), 1u);
  EXPECT_EQ(failed.cancelled[0].id, other.id);
  const Lease again = *scheduler.assign(kD, now);
  EXPECT_EQ(again.piece(), (TilePiece{part.tile, 0, 1}));
  EXPECT_FALSE(scheduler.has_pending());
}

TEST_F(EndOfQueue, APartOfALostWorkerIsPendingAgain) {
  give_to_two();
  const Lease part = *take(kC);
  scheduler.complete_part(part.id);
  const Lease second = *scheduler.assign(kC, now);
  scheduler.leave(kC, LossCause::vanished, now);
  const Lease again = *scheduler.assign(kD, now);
  EXPECT_EQ(again.piece(), second.piece());
}

TEST_F(EndOfQueue, WhatHasBegunOrIsCheapOrIsToBeCheckedStaysWhereItIs) {
  std::vector<Lease> held;
  for (const WorkerId worker : {kA, kB, kA, kB}) held.push_back(*scheduler.assign(worker, now));
  EXPECT_FALSE(take(kC)) << "nothing is known of its cost";
  for (uint32_t tile = 0; tile < 4; ++tile) scheduler.costs().note(tile, 0.0001);
  EXPECT_FALSE(take(kC)) << "it takes no time";
  note_costs();
  SchedulerEvents ignored;
  for (const WorkerId worker : {kA, kB}) {
    std::vector<LeaseProgress> all;
    for (const Lease& lease : held) {
      if (lease.worker == worker) all.push_back({lease.id, 1, true});
    }
    scheduler.report(worker, all, now, ignored);
  }
  EXPECT_FALSE(take(kC)) << "all have begun";
}

TEST_F(EndOfQueue, WhatIsToBeCheckedMovesWhole) {
  for (uint32_t tile = 0; tile < 4; ++tile) scheduler.keep_whole(tile);
  give_to_two();
  EXPECT_TRUE(take(kC)->piece().whole());
  EXPECT_EQ(scheduler.moved(), 1u);
  EXPECT_EQ(scheduler.split_tiles(), 0u);
}

TEST_F(EndOfQueue, WhoLeavesGivesBackWhatItDoesNotListAtOnce) {
  const Lease begun = *scheduler.assign(kA, now), waits = *scheduler.assign(kA, now);
  scheduler.report(kA, {{begun.id, 1, true}}, now, events, true);
  EXPECT_EQ(scheduler.held_by(kA), 1u);
  EXPECT_EQ(scheduler.assign(kB, now)->tile, waits.tile);
}

TEST_F(EndOfQueue, TilesOfASuspectAreCopiedBeforeOthersAreBegun) {
  const Lease first = *scheduler.assign(kA, now);
  scheduler.set_suspect(kA, true);
  const Lease copy = *scheduler.assign(kB, now);
  EXPECT_EQ(copy.tile, first.tile);
  EXPECT_TRUE(copy.speculative);
  EXPECT_NE(scheduler.assign(kC, now)->tile, first.tile);
}

}  // namespace
}  // namespace tessera
