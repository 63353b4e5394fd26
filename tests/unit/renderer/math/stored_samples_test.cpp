#include "renderer/math/stored_samples.h"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "renderer/math/encodings.h"

namespace tessera {
namespace {

using Names = std::vector<std::string>;

/// The names of a picture's colours and then its coverage, in the order in which a texture has
/// them.
std::string used(const Names& names) {
  std::string text;
  for (const auto& channel : color_channels_of(names).in_order()) {
    text += (text.empty() ? "" : " ") + (channel ? names[*channel] : "-");
  }
  return text;
}

TEST(StoredSamples, channels_count_by_name) {
  EXPECT_EQ(used({"R", "G", "B", "A"}), "R G B A");
  EXPECT_EQ(used({"A", "B", "G", "R"}), "R G B A");
  EXPECT_EQ(used({"r", "g", "b"}), "r g b");
  EXPECT_EQ(used({"Alpha", "Blue", "Green", "Red"}), "Red Green Blue Alpha");
  EXPECT_EQ(used({"R", "G", "B", "Z"}), "R G B");
  EXPECT_EQ(used({"B", "G", "R", "AR", "N.X"}), "R G B");
  EXPECT_EQ(used({"Y"}), "Y");
  EXPECT_EQ(used({"A", "Y"}), "Y A");
  EXPECT_EQ(used({"BY", "RY", "Y"}), "Y RY BY");
  EXPECT_EQ(used({"R", "G"}), "R G -");
  EXPECT_EQ(used({"Z", "R"}), "R");
}

TEST(StoredSamples, a_layer_counts_where_no_channel_is_without) {
  EXPECT_EQ(used({"albedo.R", "albedo.G", "albedo.B", "R", "G", "B"}), "R G B");
  EXPECT_EQ(used({"a.Z", "b.B", "b.G", "b.R", "c.A", "c.R", "c.G", "c.B"}), "b.R b.G b.B");
  EXPECT_EQ(used({"V.AO.B", "V.AO.G", "V.AO.R", "V.Combined.A", "V.Combined.B", "V.Combined.G",
                  "V.Combined.R"}),
            "V.Combined.R V.Combined.G V.Combined.B V.Combined.A");
  EXPECT_EQ(used({"mask.Y", "c.R", "c.G", "c.B"}), "c.R c.G c.B");
  EXPECT_EQ(used({"Z", "c.R", "c.G", "c.B", "A"}), "c.R c.G c.B");
}

TEST(StoredSamples, unknown_names_count_by_place_and_are_no_coverage) {
  EXPECT_EQ(used({"x"}), "x");
  EXPECT_EQ(used({"x", "y2"}), "x");
  EXPECT_EQ(used({"u", "v", "w", "x"}), "u v w");
  EXPECT_EQ(used({"u", "A"}), "u A");
  EXPECT_EQ(used({"A"}), "A");
  EXPECT_EQ(used({"N.X", "N.Y", "N.Z", "P.X", "P.Y", "P.Z"}), "N.X N.Y N.Z");
  EXPECT_EQ(used({"N.X", "N.Y", "N.Z", "c.Y"}), "c.Y");
  EXPECT_EQ(used({""}), "");
  EXPECT_EQ(used({".", "..", "R."}), ". .. R.");
}

TEST(StoredSamples, integers_are_codes_and_floats_are_light) {
  const auto light = [](float v) { return static_cast<float>(srgb_to_linear(double{v})); };
  const auto decoded = [](std::vector<float> samples, uint32_t channels, SampleMeaning meaning,
                          SampleEncoding encoding) {
    decode_samples(samples, channels, meaning, encoding);
    return samples;
  };
  const std::vector<float> rgba{.75f, .5f, .25f, .5f};
  const std::vector<float> lit{light(.75f), light(.5f), light(.25f), .5f};
  const SampleMeaning integers{.from_integers = true}, floats{};
  for (const auto encoding : {SampleEncoding::automatic, SampleEncoding::srgb})
    EXPECT_EQ(decoded(rgba, 4, integers, encoding), lit);
  EXPECT_EQ(decoded(rgba, 4, integers, SampleEncoding::linear), rgba);
  EXPECT_EQ(decoded(rgba, 4, floats, SampleEncoding::srgb), lit);
  for (const auto encoding : {SampleEncoding::automatic, SampleEncoding::linear})
    EXPECT_EQ(decoded(rgba, 4, floats, encoding), rgba);
  // Of two channels the second is alpha, of three none.
  EXPECT_EQ(decoded({.5f, .5f}, 2, integers, SampleEncoding::automatic),
            (std::vector<float>{light(.5f), .5f}));
  // Beyond the codes of integers.
  EXPECT_EQ(decoded({-.5f, 2}, 1, floats, SampleEncoding::srgb),
            (std::vector<float>{-light(.5f), light(2)}));
}

TEST(StoredSamples, associated_codes_are_divided_by_alpha_first) {
  std::array<float, 8> pixels{.375f, .25f, .125f, .5f, .5f, 0, 0, 0};
  decode_samples(pixels, 4, {.from_integers = true, .is_associated = true},
                 SampleEncoding::automatic);
  const std::array<double, 3> colors{.75, .5, .25};
  for (size_t i = 0; i < 3; ++i)
    EXPECT_EQ(pixels[i], static_cast<float>(srgb_to_linear(colors[i])) * .5f);
  EXPECT_EQ(pixels[3], .5f);
  EXPECT_EQ(pixels[4], static_cast<float>(srgb_to_linear(.5))) << "no alpha, but light";
  EXPECT_EQ(pixels[7], 0);
}

TEST(StoredSamples, luminance_and_chroma_are_colours) {
  const float y = .2126f * .75f + .7152f * .5f + .0722f * .25f;
  std::array<float, 4> pixel{y, (.75f - y) / y, (.25f - y) / y, 1};
  luminance_chroma_to_rgb(pixel, 4);
  EXPECT_NEAR(pixel[0], .75f, 1e-6);
  EXPECT_NEAR(pixel[1], .5f, 1e-6);
  EXPECT_NEAR(pixel[2], .25f, 1e-6);
  EXPECT_EQ(pixel[3], 1);
}

}  // namespace
}  // namespace tessera
