#include "front/order_outcome.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

v1::JobQuery order(v1::JobQuery::Action action) {
  v1::JobQuery query;
  query.set_action(action);
  return query;
}

v1::JobStatus status(v1::JobStatus::State state) {
  v1::JobStatus status;
  status.set_state(state);
  status.set_failure("the disk is full");
  return status;
}

TEST(OrderOutcome, IsJudgedByTheStateAndNotByTheStoresTrouble) {
  const auto paused = status(v1::JobStatus::PAUSED), running = status(v1::JobStatus::RUNNING);
  EXPECT_FALSE(unfulfilled(order(v1::JobQuery::PAUSE), paused));
  EXPECT_EQ(unfulfilled(order(v1::JobQuery::PAUSE), running), "is not paused: the disk is full");
  EXPECT_FALSE(unfulfilled(order(v1::JobQuery::RESUME), running));
  EXPECT_EQ(unfulfilled(order(v1::JobQuery::RESUME), paused), "is still paused: the disk is full");
  EXPECT_EQ(unfulfilled(order(v1::JobQuery::CANCEL), running),
            "is not cancelled: the disk is full");
  EXPECT_FALSE(unfulfilled(order(v1::JobQuery::CANCEL), status(v1::JobStatus::ENDED)));
}

TEST(OrderOutcome, TellsWhereOnlyThePriorityTookEffect) {
  v1::JobQuery query = order(v1::JobQuery::RESUME);
  query.set_priority(5);
  v1::JobStatus after = status(v1::JobStatus::PAUSED);
  after.set_priority(5);
  EXPECT_EQ(unfulfilled(query, after), "is still paused: the disk is full");
  after.set_priority(3);
  EXPECT_EQ(unfulfilled(query, after),
            "keeps its priority, 3, and is still paused: the disk is full");
  after.set_state(v1::JobStatus::RUNNING);
  EXPECT_EQ(unfulfilled(query, after), "keeps its priority, 3: the disk is full");
}

}  // namespace
}  // namespace tessera
