#include "renderer/film/film.h"

#include <gtest/gtest.h>

#include <numeric>

namespace tessera {
namespace {

TEST(Film, what_is_beside_light_can_be_left_out) {
  const AovSet aovs = AovSet().with(Aov::albedo).with(Aov::depth).with(Aov::samples);
  Film film({3, 2, 5, 4}, aovs);
  ASSERT_EQ(film.channels(), 8);
  std::iota(film.values().begin(), film.values().end(), 0.0f);
  const Film some = film.with_only(AovSet().with(Aov::depth));
  EXPECT_EQ(some.rect(), film.rect());
  ASSERT_EQ(some.values().size(), 16u);
  for (size_t i = 0; i < 4; ++i) {
    for (size_t c = 0; c < 3; ++c) EXPECT_EQ(some.values()[4 * i + c], film.values()[8 * i + c]);
    EXPECT_EQ(some.values()[4 * i + 3], film.values()[8 * i + 6]) << "Z";
  }
  EXPECT_EQ(film.pixels_sha256(), film.with_only({}).pixels_sha256());
  EXPECT_EQ(film_bytes(film.rect(), aovs), film.values().size_bytes());
}

TEST(Film, holes_have_nothing_beside_them_and_are_opaque) {
  Film film({0, 0, 2, 1}, AovSet().with(Aov::id).with(Aov::alpha));
  std::fill(film.values().begin(), film.values().end(), 7.0f);
  film.mark_hole({1, 0, 2, 1});
  EXPECT_EQ(film.values()[3], 7);
  EXPECT_EQ(film.values()[8], 0);
  EXPECT_EQ(film.values()[9], 1) << "lest the marker be unseen";
}

}  // namespace
}  // namespace tessera
