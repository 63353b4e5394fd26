#include "studio/band_queue.h"

#include <gtest/gtest.h>

#include <numeric>

namespace tessera {
namespace {

/// Takes so many bytes until it is emptied.
class NarrowSink : public PixelSink {
 public:
  bool send(std::shared_ptr<const std::string> frame) override {
    if (frame->size() > room) return false;
    room -= frame->size();
    frames.push_back(*frame);
    return true;
  }
  size_t room = 0;
  std::vector<std::string> frames;
};

int number_at(const std::string& frame, size_t at) {
  return static_cast<unsigned char>(frame[at]) | static_cast<unsigned char>(frame[at + 1]) << 8;
}

TEST(BandQueue, APictureLargerThanTheSinkArrivesInBands) {
  constexpr int kWidth = 2500, kHeight = 2000;  // 20 MB
  std::vector<uint8_t> bytes(size_t{4} * kWidth * kHeight);
  std::iota(bytes.begin(), bytes.end(), uint8_t{0});
  BandQueue queue;
  int encodings = 0;
  queue.add(
      {.kind = PixelFrame::Kind::whole,
       .rect = {0, 0, kWidth, kHeight},
       .picture_width = kWidth,
       .picture_height = kHeight,
       .flags = PixelFrame::kLastPieceOfPass},
      [&, of_bytes = pixels_of(bytes, kWidth)](const PixelRect& rect) {
        ++encodings;
        return of_bytes(rect);
      },
      false);
  NarrowSink sink;
  for (int rounds = 0; !queue.send(&sink); ++rounds) {
    ASSERT_LT(rounds, 20);
    queue.send(&sink);
    sink.room = size_t{6} << 20;
  }
  EXPECT_TRUE(queue.empty());
  EXPECT_EQ(encodings, static_cast<int>(sink.frames.size())) << "a band was made again";
  ASSERT_GT(sink.frames.size(), 4u);
  std::string together;
  for (const std::string& frame : sink.frames) {
    const bool is_last = &frame == &sink.frames.back();
    EXPECT_EQ(static_cast<PixelFrame::Kind>(frame[4]), PixelFrame::Kind::tile);
    EXPECT_EQ(number_at(frame, 14) * kWidth * 4, static_cast<int>(together.size()));
    EXPECT_EQ(number_at(frame, 30), is_last ? PixelFrame::kLastPieceOfPass : 0);
    together.append(frame, 32);
  }
  EXPECT_TRUE(std::equal(together.begin(), together.end(), bytes.begin(), bytes.end(),
                         [](char a, uint8_t b) { return static_cast<uint8_t>(a) == b; }));
}

TEST(BandQueue, AnEmptyPieceIsAFrameAndAPageThatIsGoneTakesAll) {
  BandQueue queue;
  queue.add({.rect = {}, .flags = PixelFrame::kLastPieceOfPass}, {}, true);
  NarrowSink sink;
  sink.room = 100;
  EXPECT_TRUE(queue.send(&sink));
  EXPECT_EQ(sink.frames.size(), 1u);
  queue.add(PixelFrame{}, {}, true);
  EXPECT_TRUE(queue.send(nullptr));
  EXPECT_TRUE(queue.empty());
}

}  // namespace
}  // namespace tessera
