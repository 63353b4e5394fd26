#pragma once

namespace tessera {

/// Which share of the light that rough glass does not send on at once, by one reflection or
/// refraction, leaves it in the end on the side where it came from: from random walks (Heitz,
/// Hanika, d'Eon and Dachsbacher 2016, "Multiple-Scattering Microfacet BSDFs with the Smith
/// Model"), by tests/bench/glass_walks.cpp. Between its steps by cubics.
class GlassWalks {
 public:
  static constexpr int kIndices = 17, kAlphas = 9, kCosines = 9;
  /// The steps: of the refractive index n > 1 even in the root of (n - 1) / (n + 1), 20 to 1; of
  /// alpha and of the cosine even in their roots.
  static double index_at(int step);
  static double root_alpha_at(int step) { return static_cast<double>(step) / (kAlphas - 1); }
  static double root_cosine_at(int step) { return static_cast<double>(step) / (kCosines - 1); }

  /// Of an inside of refractive index `index` > 0 and an outside of 1. Above the last
  /// step, 4.6, it is taken for that.
  explicit GlassWalks(double index);
  /// Of light on one side, along a cosine; the roots in [0, 1].
  double back(bool inside, double root_alpha, double root_cosine) const;

 private:
  double back_[2][kAlphas][kCosines];
};

}  // namespace tessera
