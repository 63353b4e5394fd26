#include "renderer/denoise/denoiser.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <random>
#include <thread>

#include "base/cancellation.h"

namespace tessera {
namespace {

constexpr int kWidth = 64, kHeight = 40;

/// A film of white things at depth 1 that face us.
Film flat_film(int width = kWidth, int height = kHeight) {
  Film film({0, 0, width, height}, denoising_aovs());
  const AovSet aovs = film.aovs();
  for (int i = 0; i < width * height; ++i) {
    float* const pixel = &film.values()[static_cast<size_t>(i * film.channels())];
    for (int c = 0; c < 3; ++c) pixel[aovs.first_channel(Aov::albedo) + c] = 1;
    pixel[aovs.first_channel(Aov::normal) + 2] = 1;
    pixel[aovs.first_channel(Aov::depth)] = 1;
  }
  return film;
}

float* pixel_of(Film& film, int x, int y) {
  return &film.values()[static_cast<size_t>((y * film.width() + x) * film.channels())];
}

/// `truth(x, y)` with noise of that deviation.
template <typename Truth>
Film noisy_film(double deviation, const Truth& truth) {
  Film film = flat_film();
  std::mt19937 random(7);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      float* const pixel = pixel_of(film, x, y);
      for (int c = 0; c < 3; ++c) {
        // The sum of twelve is near a Gaussian of deviation 1.
        double sum = -6;
        for (int i = 0; i < 12; ++i) sum += static_cast<double>(random()) * 0x1p-32;
        pixel[c] = static_cast<float>(truth(x, y) + deviation * sum);
        pixel[film.aovs().first_channel(Aov::variance) + c] =
            static_cast<float>(deviation * deviation);
      }
    }
  }
  return film;
}

template <typename Truth>
double error_of(Film& film, const Truth& truth) {
  double sum = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      for (int c = 0; c < 3; ++c) sum += std::pow(pixel_of(film, x, y)[c] - truth(x, y), 2);
    }
  }
  return std::sqrt(sum / (3 * kWidth * kHeight));
}

double mean_of(Film& film) {
  return error_of(film, [](int, int) { return 0; });
}

TEST(Denoiser, a_plain_area_keeps_its_bits) {
  Film film = noisy_film(0, [](int, int) { return 0.3; });
  const std::string before = film.pixels_sha256();
  for (int i = 0; i < kWidth * kHeight; ++i) {
    pixel_of(film, i % kWidth, i / kWidth)[film.aovs().first_channel(Aov::variance)] = 4;
  }
  denoise(film, 2);
  EXPECT_EQ(film.pixels_sha256(), before);
}

TEST(Denoiser, without_variance_nothing_changes) {
  const auto ramp = [](int x, int y) { return 0.01 * x + 0.003 * y * y; };
  Film film = noisy_film(0, ramp);
  const std::string before = film.pixels_sha256();
  denoise(film, 1);
  EXPECT_EQ(film.pixels_sha256(), before);
}

TEST(Denoiser, leaves_the_film_as_it_was_where_it_is_ended) {
  Film film = noisy_film(0.1, [](int, int) { return 0.5; });
  const std::string before = film.pixels_sha256();
  bool was_ended = true;
  // Later each time, so that some rows are smooth by then, until it comes too late.
  for (std::chrono::microseconds delay{0}; was_ended;
       delay += delay + std::chrono::microseconds(50)) {
    std::atomic<bool> flag = false;
    const std::jthread ends_it([&] {
      std::this_thread::sleep_for(delay);
      flag = true;
    });
    try {
      const Cancellation cancellation(&flag);
      denoise(film, 1);
      was_ended = false;
    } catch (const WorkCancelled&) {
      ASSERT_EQ(film.pixels_sha256(), before) << "after " << delay.count() << " us";
    }
  }
  EXPECT_NE(film.pixels_sha256(), before);
}

TEST(Denoiser, noise_goes_and_light_stays) {
  const auto flat = [](int, int) { return 0.5; };
  Film film = noisy_film(0.1, flat);
  const double before = error_of(film, flat), light = mean_of(film);
  denoise(film, 1);
  EXPECT_NEAR(before, 0.1, 0.005);
  EXPECT_LT(error_of(film, flat), 0.2 * before);
  EXPECT_NEAR(mean_of(film), light, 0.02 * light);
}

TEST(Denoiser, edges_of_light_are_kept) {
  const auto edge = [](int x, int) { return x < 29 ? 0.2 : 1.5; };
  Film film = noisy_film(0.1, edge);
  denoise(film, 1);
  EXPECT_LT(error_of(film, edge), 0.04);
  for (int y = 0; y < kHeight; ++y) {
    EXPECT_LT(pixel_of(film, 28, y)[0], 0.5);
    EXPECT_GT(pixel_of(film, 29, y)[0], 1.2);
  }
}

TEST(Denoiser, edges_of_features_are_kept_under_any_noise) {
  for (const Aov aov : {Aov::albedo, Aov::normal, Aov::depth}) {
    const auto with_right_side = [aov](float more) {
      Film film = noisy_film(1, [](int, int) { return 1; });
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) {
          float* const pixel = pixel_of(film, x, y);
          pixel[film.aovs().first_channel(aov)] = x < 29 ? 0.5f : 0.8f;
          // As far as light tells, all is alike.
          std::fill_n(pixel + film.aovs().first_channel(Aov::variance), 3, 1e6f);
          if (x >= 29) pixel[0] += more;
        }
      }
      denoise(film, 1);
      return film;
    };
    Film film = with_right_side(0), other = with_right_side(5);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < 29; ++x) {
        ASSERT_NEAR(pixel_of(film, x, y)[0], pixel_of(other, x, y)[0], 1e-3) << x << ' ' << y;
      }
    }
  }
}

TEST(Denoiser, slanted_surfaces_are_no_edges) {
  const auto flat = [](int, int) { return 0.5; };
  Film film = noisy_film(0.1, flat);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      pixel_of(film, x, y)[film.aovs().first_channel(Aov::depth)] =
          1 + 0.2f * static_cast<float>(y);
    }
  }
  denoise(film, 1);
  EXPECT_LT(error_of(film, flat), 0.045);
}

TEST(Denoiser, the_same_bits_for_any_number_of_threads) {
  const auto wave = [](int x, int y) { return 1 + std::sin(0.2 * x) * std::cos(0.3 * y); };
  Film one = noisy_film(0.2, wave);
  denoise(one, 1);
  for (const int threads : {2, 3, 8}) {
    Film many = noisy_film(0.2, wave);
    denoise(many, threads);
    EXPECT_TRUE(std::ranges::equal(one.values(), many.values()));
  }
}

TEST(Denoiser, any_finite_film_stays_finite) {
  Film film = noisy_film(0.1, [](int, int) { return 0.5; });
  const float huge = std::numeric_limits<float>::max();
  for (int c = 0; c < film.channels(); ++c) {
    pixel_of(film, 5 + 6 * c, 20)[c] = huge;
    pixel_of(film, 5 + 6 * c, 30)[c] = c < 3 ? -huge : 0;
  }
  std::fill_n(pixel_of(film, 30, 10), film.channels(), huge);
  std::fill_n(pixel_of(film, 33, 10), film.channels(), huge);
  std::fill_n(pixel_of(film, 33, 10), 3, -huge);
  denoise(film, 1);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      for (int c = 0; c < 3; ++c)
        ASSERT_TRUE(std::isfinite(pixel_of(film, x, y)[c])) << x << ' ' << y;
    }
  }
}

TEST(Denoiser, small_films_have_no_neighbours) {
  Film film = flat_film(1, 1);
  film.values()[0] = 3;
  denoise(film, 4);
  EXPECT_EQ(film.values()[0], 3);
}

}  // namespace
}  // namespace tessera
