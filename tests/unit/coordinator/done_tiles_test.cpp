// What a client sees of a frame while it is traced.
#include <gtest/gtest.h>

#include <limits>

#include "client/partial_film.h"
#include "tests/unit/coordinator/service_fixture.h"

namespace tessera::testing {
namespace {

using std::chrono::milliseconds;

v1::DoneTilesQuery first_frame(uint64_t job) {
  v1::DoneTilesQuery query;
  query.set_job(job);
  return query;
}

class DoneTilesTest : public ServiceTest {
 protected:
  v1::DoneTiles answer_to(const v1::DoneTilesQuery& query) {
    v1::Envelope message;
    *message.mutable_done_tiles_query() = query;
    coordinator.on_message(Channel::bulk, "b", message, {});
    return heard(v1::Envelope::kDoneTiles).back().done_tiles();
  }
  /// Asks until there is no more; what is new by it.
  std::vector<PixelRect> update(PartialFilm& partial) {
    std::vector<PixelRect> fresh;
    do {
      now += milliseconds(100);
      const auto question = partial.question(now);
      EXPECT_TRUE(question);
      if (!question) break;
      const auto some = partial.on_answer(answer_to(*question), now);
      fresh.insert(fresh.end(), some.begin(), some.end());
    } while (!partial.is_up_to_date());
    return fresh;
  }
  void trace(const v1::Assign& assign, float value) { say("w1", band(assign, value)); }
  static float at(const PartialFilm& partial, int x, int y) {
    return partial.film().values()[static_cast<size_t>(y * partial.film().width() + x) * 3];
  }
  Time now{};
};

TEST_F(DoneTilesTest, AreToldOnceEachWithTheirLight) {
  const uint64_t id = submit(1);
  PartialFilm partial(first_frame(id), {0, 0, 32, 32});
  EXPECT_TRUE(update(partial).empty());
  come(1, 4);
  const auto tiles = assigned();
  ASSERT_EQ(tiles.size(), 4u);
  trace(tiles[0], 1);
  trace(tiles[1], 2);
  const auto first = update(partial);
  ASSERT_EQ(first.size(), 2u);
  EXPECT_EQ(at(partial, first[0].x0, first[0].y0), 1);
  EXPECT_EQ(at(partial, first[1].x1 - 1, first[1].y1 - 1), 2);
  EXPECT_TRUE(update(partial).empty());
  trace(tiles[2], 3);
  const auto second = update(partial);
  ASSERT_EQ(second.size(), 1u);
  EXPECT_EQ(at(partial, second[0].x0, second[0].y0), 3);
  int64_t missing = 0;
  for (const PixelRect& rect : partial.missing()) missing += rect.area();
  EXPECT_EQ(missing, 16 * 16);
  trace(tiles[3], 4);
  // The frame has ended, and its film is fetched as a whole.
  EXPECT_TRUE(update(partial).empty());
  EXPECT_EQ(partial.missing().size(), 1u);
}

TEST_F(DoneTilesTest, AQuestionThatIsLostOrDoubledDoesNoHarm) {
  const uint64_t id = submit(1);
  come(1, 4);
  trace(assigned()[0], 1);
  PartialFilm partial(first_frame(id), {0, 0, 32, 32});
  const auto question = partial.question(now);
  EXPECT_FALSE(partial.question(now + milliseconds(999)));
  const auto again = partial.question(now + milliseconds(1000));
  ASSERT_TRUE(again);
  const v1::DoneTiles answer = answer_to(*question);
  EXPECT_EQ(partial.on_answer(answer, now).size(), 1u);
  EXPECT_TRUE(partial.on_answer(answer_to(*again), now).empty());
  trace(assigned()[1], 1);
  EXPECT_EQ(update(partial).size(), 1u);
  EXPECT_TRUE(partial.on_answer(answer, now).empty());
}

TEST_F(DoneTilesTest, WhoHasThoseOfAnotherRunGetsAll) {
  const uint64_t id = submit(1);
  come(1, 4);
  for (int i = 0; i < 3; ++i) trace(assigned()[static_cast<size_t>(i)], 1);
  v1::DoneTilesQuery query = first_frame(id);
  query.set_run("another");
  query.set_revision(2);
  const v1::DoneTiles answer = answer_to(query);
  EXPECT_EQ(answer.pieces_size(), 3);
  query.set_run(answer.run());
  EXPECT_EQ(answer_to(query).pieces_size(), 1);
  query.set_revision(4);
  EXPECT_EQ(answer_to(query).pieces_size(), 3);
}

TEST_F(DoneTilesTest, ComeAnewFromACoordinatorThatWasStartedAnew) {
  const uint64_t id = submit(1);
  come(1, 4);
  trace(assigned()[0], 1);
  PartialFilm partial(first_frame(id), {0, 0, 32, 32});
  EXPECT_EQ(update(partial).size(), 1u);
  restart();
  come(1, 4);
  const auto tiles = assigned();
  ASSERT_GE(tiles.size(), 3u);
  trace(tiles[0], 1);
  trace(tiles[1], 1);
  update(partial);
  int64_t missing = 0;
  for (const PixelRect& rect : partial.missing()) missing += rect.area();
  const auto done = coordinator.tiles(id, 0, now);
  const auto is_done = [](const TileSnapshot& tile) {
    return tile.state == TileSnapshot::State::done;
  };
  EXPECT_EQ(missing, 16 * 16 * (4 - std::count_if(done.begin(), done.end(), is_done)));
}

TEST_F(DoneTilesTest, OneThatIsLargerThanAMessageComesInParts) {
  constexpr int kSide = 700;
  JobSpec spec = job(kSide);
  spec.frame.set_width(2 * kSide);
  spec.crop.x1 = 2 * kSide;
  BlobStore blobs;
  v1::Envelope message = submission(5, spec, blobs);
  message.mutable_submit_job()->set_tile_size(kSide);
  submit_with(message, blobs);
  come(1, 1);
  const v1::Assign assign = assigned().at(0);
  std::vector<float> values(size_t{kSide} * kSide * 3);
  for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(i);
  for (const v1::TileBand& part : encode_bands(values, kSide, 0, false)) {
    v1::Envelope sent;
    v1::TileBand& band = *sent.mutable_tile_band();
    band = part;
    band.set_job(assign.job());
    band.set_lease(assign.lease());
    band.set_tile(assign.tile());
    say("w1", sent);
  }
  v1::DoneTilesQuery query;
  query.set_submission(5);
  PartialFilm partial(query, spec.crop);
  const auto parts = update(partial);
  EXPECT_EQ(parts.size(), 6u);
  const int x0 = parts.at(0).x0;
  int next = 0;
  for (const PixelRect& part : parts) {
    EXPECT_EQ(part.y0, next);
    EXPECT_LE(part.area() * 12, 1 << 20);
    next = part.y1;
  }
  EXPECT_EQ(next, kSide);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      ASSERT_EQ(at(partial, x0 + x, y), static_cast<float>((y * kSide + x) * 3));
    }
  }
  EXPECT_EQ(partial.missing(), (std::vector{PixelRect{kSide - x0, 0, 2 * kSide - x0, kSide}}));
}

TEST_F(DoneTilesTest, WhatIsNotOfTheFilmIsNotTaken) {
  PartialFilm partial(first_frame(1), {8, 8, 24, 24});
  const auto offer = [&](const PixelRect& rect, size_t bytes) {
    now += milliseconds(1000);
    v1::DoneTiles answer;
    answer.set_question(partial.question(now)->question());
    v1::DoneTiles::Piece& piece = *answer.add_pieces();
    piece.mutable_rect()->set_x0(rect.x0);
    piece.mutable_rect()->set_y0(rect.y0);
    piece.mutable_rect()->set_x1(rect.x1);
    piece.mutable_rect()->set_y1(rect.y1);
    piece.set_light(std::string(bytes, '\0'));
    return partial.on_answer(answer, now).size();
  };
  constexpr int kFar = std::numeric_limits<int>::max();
  EXPECT_EQ(offer({8, 8, 24, 24}, 16 * 16 * 12 - 1), 0u);
  EXPECT_EQ(offer({0, 8, 16, 24}, 16 * 16 * 12), 0u);
  EXPECT_EQ(offer({8, 8, 8, 24}, 0), 0u);
  EXPECT_EQ(offer({24, 24, 8, 8}, 16 * 16 * 12), 0u);
  EXPECT_EQ(offer({-kFar, -kFar, kFar, kFar}, 12), 0u);
  EXPECT_EQ(offer({8, 8, 24, 24}, 16 * 16 * 12), 1u);
}

}  // namespace
}  // namespace tessera::testing
