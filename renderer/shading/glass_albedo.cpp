#include "renderer/shading/glass_albedo.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "renderer/shading/coat.h"
#include "renderer/shading/glass_walks.h"
#include "renderer/shading/microfacet.h"

namespace tessera {
const GlassAlbedo::Tables& GlassAlbedo::tables() const {
  std::call_once(once_, [this] {
    auto made = std::make_unique<Tables>(Tables{integrate(false), integrate(true)});
    // Light goes through n^2 times as easily out of the rarer side, which loses more to the denser:
    // there, of what comes back, a little goes through, or the other way round.
    const bool is_dense = index_ > 1;
    const Grid<Lost>& rare = (*made)[!is_dense];
    Grid<Lost>& dense = (*made)[is_dense];
    const double n = std::max(index_, 1 / index_);
    for (int row = 0; row < Grid<Lost>::kRows; ++row) {
      const Lost mean = dense.mean_of(row);
      const double back = mean.lost - mean.through;
      if (!(back > 0)) continue;
      const double share =
          std::min((rare.mean_of(row).through / (n * n) - mean.through) / back, 1.0);
      dense.change(row,
                   [share](Lost& each) { each.through += share * (each.lost - each.through); });
    }
    tables_ = std::move(made);
  });
  return *tables_;
}

GlassAlbedo::Grid<GlassAlbedo::Lost> GlassAlbedo::integrate(bool inside) const {
  const GlassWalks walks(index_);
  const double eta = inside ? 1 / index_ : index_;
  return Grid<Lost>([&](double root_alpha, double cosine) {
    double kept = 0;
    for_each_visible_facet<16, 48>(
        root_alpha, cosine, [&](const Ggx& ggx, const Vec3& wo, const Vec3& h, double weight) {
          const double o = dot(wo, h);
          const double fresnel = fresnel_dielectric(std::clamp(o, 0.0, 1.0), eta);
          const Vec3 mirrored = h * (2 * o) - wo;
          if (mirrored.z > 0)
            kept += weight * fresnel * ggx.shadowing(mirrored, wo) / ggx.masking(wo);
          Vec3 bent;
          if (refract(-wo, h, eta, bent) && bent.z < 0)
            kept += weight * (1 - fresnel) * ggx.shadowing_through(bent, wo) / ggx.masking(wo);
        });
    const double lost = std::max(1 - kept, 0.0);
    return Lost{lost, lost * (1 - walks.back(inside, root_alpha, std::sqrt(cosine)))};
  });
}

double GlassAlbedo::coat_over_through(double coat_alpha, double alpha) const {
  constexpr int kParts = 64;
  double all = 0, turned = 0;
  for (int i = 0; i < kParts; ++i) {
    const double cosine = (i + 0.5) / kParts, sent = cosine * through(false, alpha, cosine);
    all += sent;
    turned += sent * coat_albedo(coat_alpha, cosine);
  }
  return all > 0 ? turned / all : 0;
}

const std::vector<GlassAlbedo::Grid<double>>& GlassAlbedo::coats() const {
  std::call_once(coats_once_, [this] {
    constexpr int kSteps = 4;
    const double eta = 1 / index_;
    for (int step = 0; step <= kSteps; ++step) {
      const double root = static_cast<double>(step) / kSteps;
      const double coat_alpha = root * root;
      coats_.emplace_back([&, this](double root_alpha, double cosine) {
        const double alpha = root_alpha * root_alpha;
        double back = through(true, alpha, cosine) * coat_over_through(coat_alpha, alpha);
        for_each_visible_facet<8, 32>(
            root_alpha, cosine, [&](const Ggx& ggx, const Vec3& wo, const Vec3& h, double weight) {
              Vec3 bent;
              if (!refract(-wo, h, eta, bent) || bent.z >= 0) return;
              const double fresnel = fresnel_dielectric(std::clamp(dot(wo, h), 0.0, 1.0), eta);
              back += weight * (1 - fresnel) * ggx.shadowing_through(bent, wo) / ggx.masking(wo) *
                      coat_albedo(coat_alpha, -bent.z);
            });
        return back;
      });
    }
  });
  return coats_;
}

template <typename Value>
double GlassAlbedo::between_coats(double coat_alpha, const Value& value_of) const {
  const std::vector<Grid<double>>& grids = coats();
  const int steps = static_cast<int>(grids.size()) - 1;
  const double scaled = std::sqrt(std::clamp(coat_alpha, 0.0, 1.0)) * steps;
  const int step = std::min(static_cast<int>(scaled), steps - 1);
  const double rest = scaled - step;
  return value_of(grids[step]) * (1 - rest) + value_of(grids[step + 1]) * rest;
}

double GlassAlbedo::turned_back(double coat_alpha, double alpha, double cosine) const {
  return between_coats(coat_alpha,
                       [&](const Grid<double>& grid) { return grid.at(alpha, cosine); });
}

double GlassAlbedo::mean_turned_back(double coat_alpha, double alpha) const {
  return between_coats(coat_alpha, [&](const Grid<double>& grid) { return grid.mean(alpha); });
}

std::vector<std::unique_ptr<const GlassAlbedo>> make_glass_albedos(std::span<Material> materials) {
  std::vector<std::unique_ptr<const GlassAlbedo>> made;
  std::map<double, const GlassAlbedo*> by_index;
  for (Material& material : materials) {
    if (!material.is_rough_glass()) continue;
    const GlassAlbedo*& known = by_index[material.refractive_index];
    if (!known) {
      made.push_back(std::make_unique<GlassAlbedo>(material.refractive_index));
      known = made.back().get();
    }
    material.glass_albedo = known;
  }
  return made;
}

}  // namespace tessera
