#include "studio/channel_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <span>

#include "base/error.h"
#include "studio/picture_stream.h"

namespace tessera {
namespace {

/// Two pixels beside each other with all channels; what is not set is 0.
class ChannelViewTest : public testing::Test {
 protected:
  void set(int pixel, Aov aov, std::vector<float> values) {
    const auto at = static_cast<size_t>(pixel * film_.channels() + film_.aovs().first_channel(aov));
    std::copy(values.begin(), values.end(), film_.values().subspan(at).begin());
  }
  std::vector<uint8_t> pixels(ViewChannel channel) const {
    return channel_pixels(film_, film_.rect(), legend_of(film_, channel, {}, 4), {});
  }

  Film film_{{0, 0, 2, 1}, AovSet::all()};
};

TEST_F(ChannelViewTest, NamesAreThoseOfThePage) {
  EXPECT_EQ(parse_channel("depth"), ViewChannel::depth);
  EXPECT_STREQ(name_of_channel(ViewChannel::error), "error");
  EXPECT_THROW(parse_channel("dept"), Error);
}

TEST_F(ChannelViewTest, LightIsToneMapped) {
  film_.values()[0] = 1;
  EXPECT_EQ(pixels(ViewChannel::light), (std::vector<uint8_t>{255, 0, 0, 255, 0, 0, 0, 255}));
}

TEST_F(ChannelViewTest, NormalsAreColoursAroundGrey) {
  set(0, Aov::normal, {0, 0, 1});
  EXPECT_EQ(pixels(ViewChannel::normal),
            (std::vector<uint8_t>{128, 128, 255, 255, 128, 128, 128, 255}));
}

TEST_F(ChannelViewTest, DepthGoesFromDarkBlueToYellowAndIsBlackWhereThereIsNone) {
  set(0, Aov::depth, {2});
  set(1, Aov::depth, {32});
  const Legend legend = legend_of(film_, ViewChannel::depth, {}, 1);
  EXPECT_TRUE(legend.is_scale);
  EXPECT_EQ(legend.low, 2);
  EXPECT_EQ(legend.high, 32);
  EXPECT_EQ(legend.mean, 17);
  EXPECT_EQ(legend.steps, (std::vector<double>{2, 4, 8, 16, 32}));
  EXPECT_EQ(pixels(ViewChannel::depth), (std::vector<uint8_t>{68, 1, 84, 255, 253, 231, 37, 255}));
  set(0, Aov::depth, {0});
  EXPECT_EQ(pixels(ViewChannel::depth)[0], 0);
}

TEST_F(ChannelViewTest, TheErrorIsThatOfTheMeanRelativeToDisplayWhite) {
  set(0, Aov::variance, {0.04F, 0.04F, 0.04F});
  EXPECT_NEAR(legend_of(film_, ViewChannel::error, {}, 4).high, 0.2, 1e-6);
  EXPECT_NEAR(legend_of(film_, ViewChannel::error, {.exposure = 1}, 4).high, 0.4, 1e-6);
  EXPECT_EQ(legend_of(film_, ViewChannel::error, {}, 4).low, 0);
}

TEST_F(ChannelViewTest, NeighbouringObjectsHaveOtherColours) {
  set(0, Aov::id, {1});
  set(1, Aov::id, {2});
  const auto colours = pixels(ViewChannel::id);
  EXPECT_FALSE(std::equal(colours.begin(), colours.begin() + 4, colours.begin() + 4));
}

/// Takes all that it is sent.
class Sink : public PixelSink {
 public:
  bool send(std::shared_ptr<const std::string> frame) override {
    frames.push_back(std::move(frame));
    return true;
  }
  std::vector<std::shared_ptr<const std::string>> frames;
};

TEST_F(ChannelViewTest, AnotherChannelOfAFilmThatHasItIsShownAtOnce) {
  const auto sink = std::make_shared<Sink>();
  std::vector<Legend> told;
  PictureStream stream([sink](ClientId) { return sink; },
                       [&told](const ViewId&, const Legend& legend) { told.push_back(legend); });
  set(0, Aov::depth, {2});
  set(1, Aov::depth, {5});
  stream.begin({}, {.serial = 1, .pass = {}});
  stream.finish({}, 1, std::make_shared<const Film>(film_.with_only(film_.aovs())));
  ASSERT_EQ(sink->frames.size(), 1U);
  stream.set_output({}, {}, ViewChannel::depth);
  ASSERT_EQ(sink->frames.size(), 2U);
  ASSERT_FALSE(told.empty());
  EXPECT_EQ(told.back().high, 5);
  EXPECT_EQ(sink->frames[1]->substr(32), std::string("\x44\x01\x54\xff\xfd\xe7\x25\xff"));
  EXPECT_EQ(stream.value_at({}, 1, 0)->values.size(), static_cast<size_t>(film_.channels()));
}

TEST_F(ChannelViewTest, TheErrorOfOneSampleAPixelIsToldToBeUnknown) {
  const auto sink = std::make_shared<Sink>();
  std::vector<Legend> told;
  PictureStream stream([sink](ClientId) { return sink; },
                       [&told](const ViewId&, const Legend& legend) { told.push_back(legend); });
  const auto show = [&](uint32_t serial, uint32_t samples) {
    stream.begin({}, {.serial = serial, .pass = {.scale = 1, .samples = samples}});
    stream.finish({}, serial, std::make_shared<const Film>(film_.with_only(film_.aovs())));
    return told.back().is_known;
  };
  for (const ViewChannel channel : {ViewChannel::error, ViewChannel::variance}) {
    stream.set_output({}, {}, channel);
    EXPECT_FALSE(show(1, 1));
    EXPECT_TRUE(told.back().steps.empty());
    EXPECT_TRUE(show(2, 4));
    EXPECT_EQ(told.back().high, 0) << "pixels that do not differ have no error";
  }
  stream.set_output({}, {}, ViewChannel::depth);
  EXPECT_TRUE(show(3, 1));
}

TEST_F(ChannelViewTest, LightThatCountsWorkHasAScaleAsLongAsItDoes) {
  const auto sink = std::make_shared<Sink>();
  std::vector<Legend> told;
  PictureStream stream([sink](ClientId) { return sink; },
                       [&told](const ViewId&, const Legend& legend) { told.push_back(legend); });
  const auto show = [&](uint32_t serial, bool shows_cost) {
    stream.begin({}, {.serial = serial, .pass = {}, .shows_cost = shows_cost});
    TilePixels tile{
        .rect = film_.rect(), .values = {}, .counters = {}, .channels = film_.channels()};
    tile.values.assign(film_.values().begin(), film_.values().end());
    stream.add({}, PassTiles{serial, film_.rect(), film_.aovs(), {tile}, {1}});
    stream.finish({}, serial, std::make_shared<const Film>(film_.with_only(film_.aovs())));
    return sink->frames.back()->substr(32);
  };
  film_.values()[0] = 12;
  film_.values()[static_cast<size_t>(film_.channels())] = 40;
  const std::string scale("\x44\x01\x54\xff\xfd\xe7\x25\xff");
  EXPECT_EQ(show(1, true), scale);
  EXPECT_EQ(told.back().channel, ViewChannel::cost);
  EXPECT_EQ(told.back().low, 12);
  EXPECT_EQ(told.back().high, 40);
  EXPECT_EQ(told.back().mean, 26);
  EXPECT_EQ(show(2, false), std::string("\xff\0\0\xff\xff\0\0\xff", 8))
      << "its tiles had the colours of the scale";
  EXPECT_EQ(told.back().channel, ViewChannel::light);
  EXPECT_THROW(parse_channel("cost"), Error) << "it is what the integrator makes it";
}

}  // namespace
}  // namespace tessera
