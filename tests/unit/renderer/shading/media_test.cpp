#include "renderer/shading/media.h"

#include <gtest/gtest.h>

namespace tessera {
namespace {

const Color kAbsorptions[] = {{1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {4, 0, 0},
                              {5, 0, 0}, {6, 0, 0}, {7, 0, 0}, {8, 0, 0}};

TEST(Media, TheLastEnteredCountsUntilItIsLeft) {
  Media media;
  EXPECT_EQ(media.absorption(), kBlack);
  media.enter(7, kAbsorptions[0]);
  media.enter(9, kAbsorptions[1]);
  EXPECT_EQ(media.absorption(), kAbsorptions[1]);
  media.leave(7);  // they overlap
  EXPECT_EQ(media.absorption(), kAbsorptions[1]);
  media.leave(3);  // which it was never in
  EXPECT_EQ(media.absorption(), kAbsorptions[1]);
  media.leave(9);
  EXPECT_EQ(media.absorption(), kBlack);
}

TEST(Media, WhatIsFoundOutLateIsAroundTheRest) {
  Media media;
  media.enter(1, kAbsorptions[0]);
  media.note_inside(2, kAbsorptions[1]);
  EXPECT_EQ(media.absorption(), kAbsorptions[0]);
  media.note_inside(1, kAbsorptions[2]);  // filled otherwise at the face where it is left
  EXPECT_EQ(media.absorption(), kAbsorptions[2]);
  media.leave(1);
  EXPECT_EQ(media.absorption(), kAbsorptions[1]);
}

TEST(Media, TheOutermostAreForgotten) {
  Media media;
  for (uint32_t i = 0; i < 8; ++i) media.enter(i, kAbsorptions[i]);
  media.note_inside(99, kAbsorptions[0]);
  for (uint32_t i = 7; i >= 2; --i) {
    EXPECT_EQ(media.absorption(), kAbsorptions[i]);
    media.leave(i);
  }
  EXPECT_EQ(media.absorption(), kBlack);
  EXPECT_EQ(Media::kMost, 6u);
}

}  // namespace
}  // namespace tessera
