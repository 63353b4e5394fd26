#include "studio/picture_comparison.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "studio/picture_stream.h"

namespace tessera {
namespace {

constexpr PixelRect kRect{0, 0, 4, 3};

std::shared_ptr<Film> film_of(float value, const PixelRect& rect = kRect) {
  auto film = std::make_shared<Film>(rect);
  std::fill(film->values().begin(), film->values().end(), value);
  return film;
}

TEST(PictureComparison, TellsTheNumbersOfCompare) {
  const auto reference = film_of(0.5F), picture = film_of(0.5F);
  picture->values()[3 * 5 + 1] = 0.75F;
  const nlohmann::json told = comparison_json(*picture, *reference);
  EXPECT_EQ(told["max_difference"], 0.25);
  EXPECT_EQ(told["mean_difference"], 0.25 / 36);
  EXPECT_EQ(told["differing_pixels"], 1);
  EXPECT_EQ(told["worst_pixel"], (nlohmann::json{1, 1}));
  EXPECT_GT(told["flip"], 0);
  EXPECT_LT(told["ssim"], 1);
}

TEST(PictureComparison, EqualPicturesDifferByNothing) {
  const nlohmann::json told = comparison_json(*film_of(0.5F), *film_of(0.5F));
  EXPECT_EQ(told["rmse"], 0);
  EXPECT_EQ(told["differing_pixels"], 0);
  EXPECT_FALSE(told.contains("worst_pixel"));
  const auto pixels = difference_pixels(*film_of(0.5F), *film_of(0.5F));
  for (size_t i = 0; i < pixels.size(); ++i) EXPECT_EQ(pixels[i], i % 4 == 3 ? 255 : 0);
}

TEST(PictureComparison, SaysWhyPicturesOfTwoSizesAreNotCompared) {
  const nlohmann::json told = comparison_json(*film_of(1), *film_of(1, {0, 0, 5, 3}));
  EXPECT_EQ(told["why"], "sizes differ: 4x3 is shown, 5x3 is pinned; pin it anew");
  EXPECT_FALSE(told.contains("rmse"));
}

TEST(PictureComparison, TheGreatestDifferenceIsYellowAndLessIsDarker) {
  const auto reference = film_of(0), picture = film_of(0);
  picture->values()[0] = 1;
  picture->values()[3] = 1e-4F;
  const auto pixels = difference_pixels(*picture, *reference);
  const auto greatest = scale_color(1), least = scale_color(0.01);
  EXPECT_TRUE(std::equal(greatest.begin(), greatest.end(), pixels.begin()));
  EXPECT_TRUE(std::equal(least.begin(), least.end(), pixels.begin() + 4));
}

/// What a view of 4 by 4 pixels has under the pointer while passes come and go.
class ProbeTest : public testing::Test {
 protected:
  using Values = std::vector<float>;
  void begin(uint32_t serial, int scale, int side = 4) {
    PassPicture picture;
    picture.serial = serial;
    picture.pass.scale = scale;
    picture.width = picture.height = side;
    stream_.begin(view_, picture);
  }
  void add(uint32_t serial, float value, const PixelRect& rect, const PixelRect& film) {
    const Film tile(rect);
    TilePixels pixels{.rect = rect, .values = {}, .counters = {}, .channels = kFilmChannels};
    pixels.values.assign(tile.values().size(), value);
    stream_.add(view_, PassTiles{serial, film, AovSet(), {pixels}, {1}});
  }
  void finish(uint32_t serial, float value, const PixelRect& film) {
    stream_.finish(view_, serial, film_of(value, film));
  }
  /// The light; nothing where none is known.
  Values at(int x, int y) const {
    const auto value = stream_.value_at(view_, x, y);
    return value ? value->values : Values();
  }
  static Values gray(float value) { return Values(kFilmChannels, value); }

  ViewId view_{1, 0};
  PictureStream stream_{[](ClientId) { return nullptr; }};
};

TEST_F(ProbeTest, TellsWhatIsSeenWhileThePictureRefines) {
  constexpr PixelRect kCoarse{0, 0, 2, 2}, kFine{0, 0, 4, 4};
  EXPECT_EQ(at(0, 0), Values());
  begin(1, 2);
  EXPECT_EQ(at(0, 0), Values()) << "nothing is there yet";
  add(1, 0.25F, {0, 0, 1, 2}, kCoarse);
  EXPECT_EQ(at(1, 3), gray(0.25F));
  EXPECT_EQ(at(2, 0), Values()) << "that tile is not there yet";
  finish(1, 0.25F, kCoarse);
  begin(2, 1);
  EXPECT_EQ(at(3, 3), gray(0.25F)) << "the coarse picture is seen";
  add(2, 0.5F, {0, 0, 2, 2}, kFine);
  EXPECT_EQ(at(1, 1), gray(0.5F));
  EXPECT_EQ(at(3, 3), gray(0.25F)) << "the coarse picture still is seen there";
  EXPECT_EQ(at(4, 0), Values());
  EXPECT_EQ(at(-1, 0), Values());
}

TEST_F(ProbeTest, TellsNothingOfWhatIsKeptNoMore) {
  constexpr PixelRect kAll{0, 0, 4, 4};
  begin(1, 1);
  finish(1, 0.25F, kAll);
  begin(2, 1);
  add(2, 0.5F, {0, 0, 2, 2}, kAll);
  begin(3, 1);
  EXPECT_EQ(at(1, 1), Values()) << "a tile of the pass that was given up is seen";
  add(3, 0.75F, {2, 2, 4, 4}, kAll);
  EXPECT_EQ(at(3, 3), gray(0.75F));
  finish(3, 0.75F, kAll);
  begin(4, 1, 8);
  EXPECT_EQ(at(1, 1), Values()) << "the picture of another size is seen, enlarged";
}

/// A page that has room for so many frames.
class PinSink : public PixelSink {
 public:
  bool send(std::shared_ptr<const std::string> frame) override {
    if (room == 0) return false;
    --room;
    frames.push_back(*frame);
    return true;
  }
  /// The pinned pictures that came, by their first byte of red.
  std::vector<int> pinned() const {
    std::vector<int> found;
    for (const std::string& frame : frames) {
      if (frame[4] == static_cast<char>(PixelFrame::Kind::pinned))
        found.push_back(static_cast<uint8_t>(frame[32]));
    }
    return found;
  }
  int room = 100;
  std::vector<std::string> frames;
};

class PinTest : public testing::Test {
 protected:
  using What = page::Pin::What;
  void show(uint32_t serial, const std::string& scene, const std::shared_ptr<Film>& film,
            bool is_last = true) {
    PassPicture picture;
    picture.serial = serial;
    picture.is_last = is_last;
    picture.scene = scene;
    stream_.begin(view_, picture);
    stream_.finish(view_, serial, film);
  }

  ViewId view_{1, 0};
  std::shared_ptr<PinSink> sink_ = std::make_shared<PinSink>();
  PictureStream stream_{[this](ClientId) { return sink_; }};
};

TEST_F(PinTest, WhatIsPinnedStaysWhilePicturesFollow) {
  EXPECT_EQ(stream_.pin(view_, What::shown), nullptr) << "nothing is shown";
  const auto first = film_of(1), second = film_of(0);
  show(1, "a", first);
  EXPECT_EQ(stream_.pin(view_, What::shown), first);
  show(2, "b", second);
  const auto pair = stream_.pair(view_);
  ASSERT_TRUE(pair);
  EXPECT_EQ(pair->pinned, first);
  EXPECT_EQ(pair->shown, second);
  EXPECT_EQ(pair->serial, 2U);
  EXPECT_EQ(stream_.pin(view_, What::none), nullptr);
  EXPECT_FALSE(stream_.pair(view_));
}

TEST_F(PinTest, BeforeIsTheLastWholePictureOfTheSceneAsItWas) {
  const auto first = film_of(1);
  show(1, "a", first);
  EXPECT_EQ(stream_.pin(view_, What::before), nullptr) << "the scene was not changed";
  show(2, "a", film_of(0.5F));
  EXPECT_EQ(stream_.pin(view_, What::before), nullptr) << "as with another camera";
  show(3, "a", first);
  show(4, "b", film_of(0), false);
  show(5, "c", film_of(0));
  EXPECT_EQ(stream_.pin(view_, What::before), first) << "what was not finished does not count";
  stream_.forget(view_);
  EXPECT_EQ(stream_.pin(view_, What::before), nullptr);
}

TEST_F(PinTest, APinnedPictureIsSentAgainForAnotherToneAndWhereThereWasNoRoom) {
  show(1, "a", film_of(0.25F));
  stream_.pin(view_, What::shown);
  EXPECT_EQ(sink_->pinned().size(), 1U);
  OutputSettings brighter;
  brighter.exposure = 10;
  stream_.set_output(view_, brighter, ViewChannel::light);
  ASSERT_EQ(sink_->pinned().size(), 2U);
  EXPECT_GT(sink_->pinned()[1], sink_->pinned()[0]);
  sink_->room = 0;
  stream_.pin(view_, What::shown);
  EXPECT_TRUE(stream_.catch_up());
  sink_->room = 100;
  EXPECT_FALSE(stream_.catch_up());
  EXPECT_EQ(sink_->pinned().size(), 3U);
}

}  // namespace
}  // namespace tessera
