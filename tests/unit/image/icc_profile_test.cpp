#include "image/plain/icc_profile.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <string>

namespace tessera {
namespace {

void put(std::string& out, uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(value >> shift);
}
void put_fixed(std::string& out, double value) {
  put(out, static_cast<uint32_t>(static_cast<int32_t>(value * 65536)));
}

/// A profile of three colorants, x y z each, and one curve for all.
std::string profile(const std::array<double, 9>& colorants, const std::string& curve) {
  const std::array<std::string, 6> names{"rXYZ", "gXYZ", "bXYZ", "rTRC", "gTRC", "bTRC"};
  std::string header(16, '\0'), table, data;
  header += "RGB XYZ ";
  header.resize(128);
  put(table, 6);
  for (size_t i = 0; i < names.size(); ++i) {
    std::string entry = curve;
    if (i < 3) {
      entry = std::string("XYZ ") + std::string(4, '\0');
      for (size_t k = 0; k < 3; ++k) put_fixed(entry, colorants[3 * i + k]);
    }
    table += names[i];
    put(table, static_cast<uint32_t>(132 + 6 * 12 + data.size()));
    put(table, static_cast<uint32_t>(entry.size()));
    data += entry;
  }
  return header + table + data;
}

std::string gamma_curve(double gamma) {
  std::string out = std::string("curv") + std::string(4, '\0');
  put(out, 1);
  const auto fixed = static_cast<uint32_t>(gamma * 256);
  out += static_cast<char>(fixed >> 8);
  out += static_cast<char>(fixed);
  return out;
}

constexpr std::array<double, 9> kAdobe{.60974, .31111, .01947, .20528, .62567,
                                       .06087, .14919, .06322, .74457};
constexpr std::array<double, 9> kSrgb{.43607, .22249, .01392, .38515, .71687,
                                      .09708, .14307, .06061, .71410};

using Pixel = std::array<int, 3>;

Pixel converted(const std::string& by, const Pixel& pixel) {
  std::array<char, 3> codes{};
  for (size_t c = 0; c < 3; ++c) codes[c] = static_cast<char>(pixel[c]);
  const auto conversion =
      SrgbConversion::from({reinterpret_cast<const unsigned char*>(by.data()), by.size()});
  if (conversion) conversion->convert(codes, 3);
  Pixel out{};
  for (size_t c = 0; c < 3; ++c) out[c] = static_cast<unsigned char>(codes[c]);
  return out;
}

TEST(IccProfile, TakesAWiderSpaceToSrgb) {
  const std::string adobe = profile(kAdobe, gamma_curve(563.0 / 256));
  EXPECT_EQ(converted(adobe, {100, 150, 200}), (Pixel{66, 151, 203}));
  EXPECT_EQ(converted(adobe, {200, 100, 50}), (Pixel{227, 100, 42}));
  EXPECT_EQ(converted(adobe, {255, 255, 255}), (Pixel{255, 255, 255}));
  EXPECT_EQ(converted(adobe, {0, 255, 0}), (Pixel{0, 255, 0}));  // outside of sRGB: clipped
}

TEST(IccProfile, KnowsParametricCurvesAndTables) {
  std::string para = std::string("para") + std::string(4, '\0') + std::string(4, '\0');
  put_fixed(para, 1);
  // Linear light: half of it is code 188 of sRGB.
  EXPECT_EQ(converted(profile(kSrgb, para), {128, 128, 128})[0], 188);
  std::string table = std::string("curv") + std::string(4, '\0');
  put(table, 2);
  table += std::string("\0\0\xff\xff", 4);
  EXPECT_EQ(converted(profile(kSrgb, table), {128, 128, 128})[0], 188);
}

TEST(IccProfile, LeavesWhatIsSrgbAsItIs) {
  std::string para = std::string("para") + std::string(4, '\0') + std::string("\0\3\0\0", 4);
  for (const double p : {2.4, 1 / 1.055, .055 / 1.055, 1 / 12.92, .04045}) put_fixed(para, p);
  for (const Pixel& pixel : {Pixel{1, 2, 3}, Pixel{100, 150, 200}, Pixel{255, 0, 7}})
    EXPECT_EQ(converted(profile(kSrgb, para), pixel), pixel);
}

TEST(IccProfile, LeavesWhatItDoesNotKnow) {
  const std::string adobe = profile(kAdobe, gamma_curve(563.0 / 256));
  const Pixel pixel{100, 150, 200};
  for (size_t size = 0; size < adobe.size(); ++size)
    EXPECT_EQ(converted(adobe.substr(0, size), pixel), pixel) << size;
  std::string lab = adobe;
  lab.replace(20, 4, "Lab ");
  EXPECT_EQ(converted(lab, pixel), pixel);
  std::string far = adobe;
  far.replace(132 + 4, 4, "\xff\xff\xff\xf0");
  EXPECT_EQ(converted(far, pixel), pixel);
}

}  // namespace
}  // namespace tessera
