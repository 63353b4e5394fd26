#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "renderer/shading/albedo_grid.h"
#include "renderer/shading/material.h"

namespace tessera {

/// How much of evenly arriving light the rough facets of glass lose, where each ray leaves them by
/// one reflection or refraction: what would go on to other facets (Kulla and Conty 2017,
/// "Revisiting Physically Based Shading", of dielectrics); and how much of that goes through in the
/// end (GlassWalks). By the side that it arrives from, which is inside or outside, to a few
/// thousandths. Worked out when first asked, which takes some 50 ms; any thread.
class GlassAlbedo {
 public:
  /// Of facets between an inside of `index` and an outside of 1; index > 0 and not 1.
  explicit GlassAlbedo(double index) : index_(index) {}

  /// Of light along `cosine` in (0, 1]; `alpha` in (0, 1].
  double lost(bool inside, double alpha, double cosine) const {
    return tables()[inside].at(alpha, cosine).lost;
  }
  /// Its mean over the hemisphere, by the cosine.
  double mean_lost(bool inside, double alpha) const { return tables()[inside].mean(alpha).lost; }
  /// What of lost() goes through in the end, and the mean of that; such that what goes either way
  /// is the same (Helmholtz).
  double through(bool inside, double alpha, double cosine) const {
    return tables()[inside].at(alpha, cosine).through;
  }
  double mean_through(bool inside, double alpha) const {
    return tables()[inside].mean(alpha).through;
  }

  /// The share of light from inside, along `cosine`, that a coat (coat.h) of `coat_alpha` outside
  /// turns back where it would leave, at once or in the end. Worked out when first asked, too.
  double turned_back(double coat_alpha, double alpha, double cosine) const;
  /// Its mean over the hemisphere, by the cosine.
  double mean_turned_back(double coat_alpha, double alpha) const;

 private:
  struct Lost {
    double lost = 0, through = 0;
    friend Lost operator+(const Lost& a, const Lost& b) {
      return {a.lost + b.lost, a.through + b.through};
    }
    friend Lost operator*(const Lost& a, double s) { return {a.lost * s, a.through * s}; }
  };
  template <typename Value>
  using Grid = AlbedoGrid<Value, 16, 16>;
  using Tables = std::array<Grid<Lost>, 2>;  ///< the outside first
  Grid<Lost> integrate(bool inside) const;
  const Tables& tables() const;
  /// The share that a coat turns back of what leaves evenly between facets.
  double coat_over_through(double coat_alpha, double alpha) const;
  /// By the root of the coat's alpha.
  const std::vector<Grid<double>>& coats() const;
  template <typename Value>
  double between_coats(double coat_alpha, const Value& value_of) const;

  double index_;
  mutable std::once_flag once_, coats_once_;
  mutable std::unique_ptr<const Tables> tables_;
  mutable std::vector<Grid<double>> coats_;
};

/// Gives each that is_rough_glass() the one of its refractive index; returned is who owns them.
std::vector<std::unique_ptr<const GlassAlbedo>> make_glass_albedos(std::span<Material> materials);

}  // namespace tessera
