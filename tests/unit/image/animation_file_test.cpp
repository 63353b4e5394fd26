#include "image/animation_file.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <map>
#include <string>
#include <vector>

#include "base/error.h"
#include "image/image_file.h"

namespace tessera {
namespace {

Film film_of(float light, int width = 5, int height = 3) {
  Film film({0, 0, width, height});
  for (size_t i = 0; i < film.values().size(); ++i)
    film.values()[i] = light * static_cast<float>(i) / static_cast<float>(film.values().size());
  return film;
}

std::string picture(const char* name, const Film& film) {
  return encode_image(name, film, {}, {.scene_digest = "abc"});
}

struct Chunk {
  std::string kind, data;
};

/// The chunks of a PNG, whose check sums are right.
std::vector<Chunk> chunks_of(const std::string& file) {
  const auto number = [&](size_t at) {
    uint32_t value = 0;
    for (size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<uint8_t>(file.at(at + i));
    return value;
  };
  std::vector<Chunk> chunks;
  for (size_t at = 8; at < file.size();) {
    const uint32_t length = number(at);
    const auto* const summed = reinterpret_cast<const Bytef*>(file.data()) + at + 4;
    EXPECT_EQ(crc32(0, summed, length + 4), number(at + 8 + length));
    chunks.push_back({file.substr(at + 4, 4), file.substr(at + 8, length)});
    at += length + 12;
  }
  return chunks;
}

std::string pixels_of(const std::vector<Chunk>& chunks) {
  std::string pixels;
  for (const Chunk& chunk : chunks) {
    if (chunk.kind == "IDAT") pixels += chunk.data;
  }
  return pixels;
}

TEST(AnimationFile, OnlyGifAndApngHoldFrames) {
  EXPECT_TRUE(holds_frames("a.gif"));
  EXPECT_TRUE(holds_frames("a.b/c.APNG"));
  EXPECT_FALSE(holds_frames("a.png"));
  EXPECT_FALSE(holds_frames("gif"));
}

TEST(AnimationFile, FramesOfPngAreThoseOfTheirOwnFiles) {
  const std::vector<std::string> pictures = {picture("a.apng", film_of(1)),
                                             picture("a.apng", film_of(.5F)),
                                             picture("a.apng", film_of(.25F))};
  AnimationFile animation("a.apng");
  for (const std::string& each : pictures) animation.add(each);
  const std::vector<Chunk> chunks = chunks_of(animation.bytes(24));
  std::vector<std::string> frames;
  uint32_t number = 0;
  for (const Chunk& chunk : chunks) {
    if (chunk.kind == "acTL") {
      EXPECT_EQ(chunk.data, std::string("\0\0\0\3\0\0\0\0", 8));
    }
    if (chunk.kind == "IDAT") frames.push_back(chunk.data);
    if (chunk.kind == "fdAT") frames.push_back(chunk.data.substr(4));
    if (chunk.kind != "fcTL" && chunk.kind != "fdAT") continue;
    EXPECT_EQ(chunk.data.substr(0, 4), std::string("\0\0\0", 3) + static_cast<char>(number++));
    if (chunk.kind != "fcTL") continue;
    // 5x3 at 0,0 for 1/24 s, replacing what was there.
    const char expected[] = "\0\0\0\5\0\0\0\3\0\0\0\0\0\0\0\0\0\1\0\x18\0\0";
    EXPECT_EQ(chunk.data.substr(4), std::string(expected, sizeof expected - 1));
  }
  ASSERT_EQ(frames.size(), 3U);
  for (size_t i = 0; i < frames.size(); ++i)
    EXPECT_EQ(frames[i], pixels_of(chunks_of(pictures[i]))) << i;
  EXPECT_EQ(chunks.front().kind, "IHDR");
  EXPECT_EQ(chunks[1].kind, "acTL");
  EXPECT_EQ(chunks.back().kind, "IEND");
}

TEST(AnimationFile, RatesOfFilmsAreFractionsOfPng) {
  AnimationFile animation("a.apng");
  animation.add(picture("a.apng", film_of(1)));
  const std::map<double, std::string> delays = {{24, std::string("\0\1\0\x18", 4)},
                                                {24000. / 1001, "\x03\xe9\x5d\xc0"},
                                                {12.5, std::string("\0\2\0\x19", 4)},
                                                {.1, std::string("\0\x0a\0\1", 4)}};
  for (const auto& [rate, delay] : delays) {
    for (const Chunk& chunk : chunks_of(animation.bytes(rate))) {
      if (chunk.kind == "fcTL") {
        EXPECT_EQ(chunk.data.substr(20, 4), delay) << rate;
      }
    }
  }
}

TEST(AnimationFile, AGifThatIsTooLargeIsRefused) {
  const Film film({0, 0, 65536, 1});
  EXPECT_THROW(encode_image("a.gif", film, {}, {}), Error);
  EXPECT_NO_THROW(encode_image("a.apng", film, {}, {}));
}

TEST(AnimationFile, DelaysOfGifAddUpToTheFramesTimes) {
  AnimationFile animation("a.gif");
  for (int frame = 0; frame < 24; ++frame)
    animation.add(picture("a.gif", film_of(static_cast<float>(frame) / 24)));
  const std::string bytes = animation.bytes(24);
  const std::string control("!\xf9\x04", 3);
  int hundredths = 0, frames = 0;
  for (size_t at = bytes.find(control); at != std::string::npos; at = bytes.find(control, at + 1)) {
    const int delay = static_cast<uint8_t>(bytes[at + 4]);
    EXPECT_TRUE(delay == 4 || delay == 5);
    hundredths += delay;
    ++frames;
  }
  EXPECT_EQ(frames, 24);
  EXPECT_EQ(hundredths, 100);
  // Shorter ones than two hundredths are shown for longer.
  EXPECT_EQ(animation.nearest_rate(60), 50);
  EXPECT_EQ(animation.nearest_rate(40), 40);
  EXPECT_EQ(AnimationFile("a.apng").nearest_rate(60), 60);
  const std::string fast = animation.bytes(1000);
  EXPECT_EQ(fast[fast.find(control) + 4], 2);
}

TEST(AnimationFile, AnotherSizeIsRefused) {
  for (const char* name : {"a.apng", "a.gif"}) {
    AnimationFile animation(name);
    animation.add(picture(name, film_of(1)));
    EXPECT_THROW(animation.add(picture(name, film_of(1, 5, 4))), Error) << name;
    EXPECT_EQ(animation.frames(), 1U) << name;
  }
}

}  // namespace
}  // namespace tessera
