#include "studio/picture_stream.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace tessera {
namespace {

constexpr int kPageSide = 4;
constexpr PixelRect kPage{0, 0, kPageSide, kPageSide}, kLeft{0, 0, 2, kPageSide},
    kRight{2, 0, kPageSide, kPageSide};

/// A page that paints what it is sent, as studio/page/src/core/picture.ts does. It has a pane of 4
/// by 4 pixels.
class PaintedPage : public PixelSink {
 public:
  bool send(std::shared_ptr<const std::string> bytes) override {
    const auto at = [&](size_t place) { return static_cast<uint8_t>((*bytes)[place]); };
    if (at(4) > static_cast<uint8_t>(PixelFrame::Kind::whole) || at(8) < serial_) return true;
    serial_ = at(8);
    is_complete_ = at(30) == (PixelFrame::kLastPieceOfPass | PixelFrame::kLastPass);
    const int scale = at(7), x0 = at(12), y0 = at(14), width = at(16), height = at(18);
    for (int y = y0 * scale; y < (y0 + height) * scale; ++y) {
      for (int x = x0 * scale; x < (x0 + width) * scale; ++x) {
        const int pixel = (y / scale - y0) * width + x / scale - x0;
        red_[static_cast<size_t>(y * kPageSide + x)] = at(32 + 4 * static_cast<size_t>(pixel));
      }
    }
    return true;
  }
  /// The values of red that are seen.
  std::set<int> reds() const { return {red_.begin(), red_.end()}; }
  bool is_complete() const { return is_complete_; }

 private:
  uint8_t serial_ = 0;
  bool is_complete_ = false;
  std::array<int, size_t{kPageSide} * kPageSide> red_{};
};

class ToneTest : public testing::Test {
 protected:
  ToneTest() { brighter_.exposure = 1; }
  void begin(uint32_t serial, int scale = 1) {
    PassPicture picture;
    picture.serial = serial;
    picture.is_last = true;
    picture.pass.scale = scale;
    picture.width = picture.height = kPageSide;
    stream_.begin(view_, picture);
  }
  void add(uint32_t serial, const PixelRect& rect) {
    const Film tile(rect);
    TilePixels pixels{.rect = rect, .values = {}, .counters = {}, .channels = kFilmChannels};
    pixels.values.assign(tile.values().size(), kLight);
    stream_.add(view_, PassTiles{serial, kPage, AovSet(), {pixels}, {1}});
  }
  void finish(uint32_t serial, const PixelRect& rect = kPage) {
    auto film = std::make_shared<Film>(rect);
    std::fill(film->values().begin(), film->values().end(), kLight);
    stream_.finish(view_, serial, film);
  }
  void brighten() { stream_.set_output(view_, brighter_, ViewChannel::light); }
  void darken() { stream_.set_output(view_, {}, ViewChannel::light); }
  int red(const OutputSettings& output) const {
    Film film(kPage);
    std::fill(film.values().begin(), film.values().end(), kLight);
    return channel_pixels(film, kPage, {}, output)[0];
  }
  std::set<int> dark() const { return {red({})}; }
  std::set<int> bright() const { return {red(brighter_)}; }

  static constexpr float kLight = 0.1F;
  ViewId view_{1, 0};
  OutputSettings brighter_;
  std::shared_ptr<PaintedPage> page_ = std::make_shared<PaintedPage>();
  PictureStream stream_{[this](ClientId) { return page_; }};
};

TEST_F(ToneTest, IsThatOfTheWholePictureWhileAPassRefinesIt) {
  begin(1, 2);
  finish(1, {0, 0, 2, 2});
  EXPECT_EQ(page_->reds(), dark());
  EXPECT_TRUE(page_->is_complete());
  begin(2);
  add(2, kLeft);
  brighten();
  EXPECT_EQ(page_->reds(), bright());
  EXPECT_FALSE(page_->is_complete());
  add(2, kRight);
  finish(2);
  EXPECT_EQ(page_->reds(), bright());
  EXPECT_TRUE(page_->is_complete());
  darken();
  EXPECT_EQ(page_->reds(), dark());
  EXPECT_TRUE(page_->is_complete());
}

TEST_F(ToneTest, IsThatOfTilesOfPassesThatWereGivenUpToo) {
  begin(1);
  finish(1);
  begin(2);
  add(2, kLeft);
  begin(3);
  brighten();
  EXPECT_EQ(page_->reds(), bright());
  darken();
  EXPECT_EQ(page_->reds(), dark());
  add(3, kRight);
  brighten();
  EXPECT_EQ(page_->reds(), bright());
}

TEST_F(ToneTest, TilesThatNothingIsKeptOfAreSeenNoLonger) {
  begin(1);
  add(1, kLeft);
  begin(2);
  brighten();
  EXPECT_EQ(page_->reds(), std::set<int>{0}) << "of the first pass there is no film any more";
  add(2, kLeft);
  add(2, kRight);
  EXPECT_EQ(page_->reds(), bright());
}

}  // namespace
}  // namespace tessera
