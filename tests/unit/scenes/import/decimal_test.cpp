#include "scenes/import/decimal.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <bit>
#include <charconv>
#include <cmath>
#include <random>
#include <string>
#include <string_view>

namespace tessera {
namespace {

using namespace std::string_literals;

float read(std::string_view text, size_t* length = nullptr) {
  float value = -1;
  const char* const stop = read_short_decimal(text.data(), text.data() + text.size(), value);
  if (length) *length = stop ? static_cast<size_t>(stop - text.data()) : 0;
  return value;
}

/// What the library reads; its bits, so that -0 is not 0.
uint32_t bits_by_library(const std::string& text) {
  float value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return std::bit_cast<uint32_t>(value);
}

TEST(ShortDecimal, ReadsUpToWhatIsNoDigit) {
  size_t length = 0;
  EXPECT_EQ(read("12.5 7", &length), 12.5f);
  EXPECT_EQ(length, 4u);
  EXPECT_EQ(read("-3/", &length), -3.f);
  EXPECT_EQ(length, 2u);
  EXPECT_EQ(read("4.x", &length), 4.f);
  EXPECT_EQ(length, 2u);
  EXPECT_EQ(read(".25", &length), .25f);
  EXPECT_EQ(length, 3u);
}

TEST(ShortDecimal, LeavesWhatIsUnusual) {
  for (const char* text : {"", "-", ".", "-.", "+1", "inf", "nan", "1e3", "1.E3",
                           "1234567890123456", "0.1234567890123456", "16777217"}) {
    size_t length = 1;
    EXPECT_EQ(read(text, &length), -1.f) << text;
    EXPECT_EQ(length, 0u) << text;
  }
}

TEST(ShortDecimal, GivesTheNearestFloat) {
  constexpr unsigned kSeed = 20261122;
  std::mt19937_64 random(kSeed);
  int taken = 0;
  const auto check = [&](const std::string& text) {
    size_t length = 0;
    const float value = read(text, &length);
    if (length == 0) return;
    ++taken;
    ASSERT_EQ(length, text.size()) << text;
    ASSERT_EQ(std::bit_cast<uint32_t>(value), bits_by_library(text)) << text << " seed " << kSeed;
  };
  for (int i = 0; i < 300'000; ++i) {
    const int digits = 1 + static_cast<int>(random() % 15);
    std::string text;
    for (int d = 0; d < digits; ++d) text += static_cast<char>('0' + random() % 10);
    text.insert(random() % (text.size() + 1), ".");
    check((random() % 2 ? "-" : "") + text);
  }
  EXPECT_GT(taken, 299'000) << "all but whole numbers between two floats";
  // So near the middle between two floats that it is the nearest double.
  for (int i = 0; i < 100'000; ++i) {
    const float below = 1 + static_cast<float>(random() % 9'000'000) / 1e6f;
    const double middle = (double{below} + double{std::nextafter(below, 10.f)}) / 2;
    check(fmt::format("{:.14f}", middle));
  }
}

template <typename Number>
std::errc problem_of(std::string_view text, Number* value = nullptr) {
  Number read = 7;
  const auto [stop, problem] = read_decimal(text.data(), text.data() + text.size(), read);
  if (problem == std::errc()) {
    EXPECT_EQ(stop, text.data() + text.size()) << text;
  }
  if (value) *value = read;
  return problem;
}

TEST(Decimal, TakesOneSignOfEitherKind) {
  for (const char* text : {"+5", "+5e0", "5"}) {
    float single = 0;
    double both = 0;
    EXPECT_EQ(problem_of(text, &single), std::errc()) << text;
    EXPECT_EQ(problem_of(text, &both), std::errc()) << text;
    EXPECT_EQ(single, 5.f) << text;
    EXPECT_EQ(both, 5.0) << text;
  }
  for (const char* text : {"+-5", "++5", "-+5", "--5", "+", "-", "", "+-5e0"}) {
    EXPECT_EQ(problem_of<float>(text), std::errc::invalid_argument) << text;
    EXPECT_EQ(problem_of<double>(text), std::errc::invalid_argument) << text;
  }
}

TEST(Decimal, TakesWhatIsTooSmallForZero) {
  float value = 1;
  EXPECT_EQ(problem_of("1e-60", &value), std::errc());
  EXPECT_EQ(value, 0.f);
  EXPECT_EQ(problem_of("-.00000000000000000000000000000000000000001", &value), std::errc());
  EXPECT_EQ(value, -1e-41f);
  const std::string many_zeros = "0." + std::string(400, '0') + "1";
  for (const std::string& text : {"1e-400"s, "123.5e-99999999999999999999"s, many_zeros}) {
    double both = 1;
    EXPECT_EQ(problem_of(text, &both), std::errc()) << text;
    EXPECT_EQ(both, 0) << text;
    EXPECT_EQ(problem_of("-" + text, &value), std::errc()) << text;
    EXPECT_EQ(value, 0.f) << text;
    EXPECT_TRUE(std::signbit(value)) << text;
  }
  const std::string many_digits = "1" + std::string(400, '0');
  for (const std::string& text : {"1e400"s, "1e99999999999999999999"s, many_digits, ".1e400"s}) {
    EXPECT_EQ(problem_of<float>(text), std::errc::result_out_of_range) << text;
    EXPECT_EQ(problem_of<double>(text), std::errc::result_out_of_range) << text;
  }
  EXPECT_EQ(problem_of<float>("1e60"), std::errc::result_out_of_range);
  EXPECT_EQ(problem_of<double>("1e400"), std::errc::result_out_of_range);
}

}  // namespace
}  // namespace tessera
