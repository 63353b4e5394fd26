#include "coordinator/jobs/film_shelf.h"

#include <gtest/gtest.h>

#include "coordinator/jobs/memory_job_store.h"
#include "coordinator/tiles/assembler.h"
#include "tests/address_space_limit.h"

namespace tessera {
namespace {

/// Counts how often films are put together.
struct CountingStore : MemoryJobStore {
  std::vector<FinishedTile> find(const Digest& key) override {
    ++asked;
    return MemoryJobStore::find(key);
  }
  int asked = 0;
};

class FilmShelfTest : public ::testing::Test {
 protected:
  static constexpr PixelRect kCrop{0, 0, 8, 8};
  static constexpr uint64_t kFilmBytes = 8 * 8 * 12;

  /// A film of one colour, whose only tile the store keeps.
  Digest put(FilmShelf& shelf, float value) {
    Assembler assembler(kCrop, {kCrop});
    const std::array<float, 3> pixel{value, value, value};
    assembler.fill(0, pixel, {}, 1);
    FinishedTile tile{kCrop, {}};
    for (const v1::TileBand& band : assembler.bands_of(0)) *tile.kept.add_bands() = band;
    const Digest key = Digest::of(std::to_string(value));
    store->keep(key, tile);
    return shelf.put(std::move(assembler.film()), {key, kCrop, 8});
  }
  std::shared_ptr<CountingStore> store = std::make_shared<CountingStore>();
};

TEST_F(FilmShelfTest, KeepsSmallFilmsAtHandHoweverMany) {
  FilmShelf shelf(store);
  std::vector<Digest> films;
  for (int i = 0; i < 50; ++i) films.push_back(put(shelf, static_cast<float>(i)));
  for (int turn = 0; turn < 3; ++turn) {
    for (const Digest& film : films) EXPECT_EQ(shelf.find(film)->size(), kFilmBytes);
  }
  EXPECT_EQ(store->asked, 0);
}

TEST_F(FilmShelfTest, KeepsNoMoreBytesThanItMayAndThoseAskedForLast) {
  FilmShelf shelf(store, 2 * kFilmBytes);
  const Digest one = put(shelf, 1), two = put(shelf, 2);
  EXPECT_TRUE(shelf.find(one));
  put(shelf, 3);
  EXPECT_TRUE(shelf.find(one));
  EXPECT_EQ(store->asked, 0) << "it was asked for after the second";
  EXPECT_TRUE(shelf.find(two));
  EXPECT_EQ(store->asked, 1) << "put together again";
}

TEST_F(FilmShelfTest, OneThatThereIsNoMemoryForIsNotShown) {
  if (!AddressSpaceLimit::kWorks) GTEST_SKIP() << AddressSpaceLimit::kWhyNot;
  FilmShelf shelf(store);
  const Digest film = Digest::of(std::string("large"));
  shelf.note(film, {film, {0, 0, 8192, 8192}, 512});
  const AddressSpaceLimit limit(rlim_t{256} << 20);
  FilmShelf::State state = FilmShelf::State::sound;
  EXPECT_FALSE(shelf.find(film, &state));
  EXPECT_EQ(state, FilmShelf::State::sound) << "it need not be traced again";
}

TEST_F(FilmShelfTest, KeepsOneThatIsTooLarge) {
  FilmShelf shelf(store, 1);
  const Digest film = put(shelf, 1);
  EXPECT_TRUE(shelf.find(film));
  EXPECT_TRUE(shelf.find(film));
  EXPECT_EQ(store->asked, 0);
}

}  // namespace
}  // namespace tessera
