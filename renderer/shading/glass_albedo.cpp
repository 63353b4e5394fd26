#include "renderer/shading/glass_albedo.h"

#include <algorithm>
#include <map>

#include "renderer/shading/coat.h"
#include "renderer/shading/microfacet.h"

namespace tessera {
namespace {

/// The mean, by the cosine, of what a smooth face lets through.
double mean_transmittance(double eta) {
  constexpr int kParts = 4096;
  double sum = 0;
  for (int i = 0; i < kParts; ++i) {
    const double cosine = (i + 0.5) / kParts;
    sum += 2 * cosine * (1 - fresnel_dielectric(cosine, eta));
  }
  return sum / kParts;
}

}  // namespace

const GlassAlbedo::Tables& GlassAlbedo::tables() const {
  std::call_once(once_, [this] {
    // What goes through either way is the same, but for n^2.
    const double out = mean_transmittance(index_), in = out / (index_ * index_);
    tables_ =
        std::make_unique<Tables>(Tables{{integrate(index_), integrate(1 / index_)}, {out, in}});
  });
  return *tables_;
}

GlassAlbedo::Grid GlassAlbedo::integrate(double eta) {
  return Grid([eta](double root_alpha, double cosine) {
    double kept = 0;
    for_each_visible_facet<16, 48>(
        root_alpha, cosine, [&](const Ggx& ggx, const Vec3& wo, const Vec3& h, double weight) {
          const double o = dot(wo, h);
          const double fresnel = fresnel_dielectric(std::clamp(o, 0.0, 1.0), eta);
          const auto leaves = [&](const Vec3& wi) {
            return ggx.shadowing(wi, wo) / ggx.masking(wo);
          };
          const Vec3 mirrored = h * (2 * o) - wo;
          if (mirrored.z > 0) kept += weight * fresnel * leaves(mirrored);
          Vec3 bent;
          if (refract(-wo, h, eta, bent) && bent.z < 0)
            kept += weight * (1 - fresnel) * leaves(bent);
        });
    return kept;
  });
}

double GlassAlbedo::through(bool inside, double alpha) const {
  // More of what is lost than comes back from the other side cannot go there.
  const double here = mean_lost(inside, alpha), beyond = mean_lost(!inside, alpha);
  return tables().transmits[inside] * (here > beyond ? beyond / here : 1);
}

const std::vector<GlassAlbedo::Grid>& GlassAlbedo::coats() const {
  std::call_once(coats_once_, [this] {
    constexpr int kSteps = 4;
    const double eta = 1 / index_;
    for (int step = 0; step <= kSteps; ++step) {
      const double root = static_cast<double>(step) / kSteps;
      coats_.emplace_back([eta, root](double root_alpha, double cosine) {
        double back = 0;
        for_each_visible_facet<8, 32>(
            root_alpha, cosine, [&](const Ggx& ggx, const Vec3& wo, const Vec3& h, double weight) {
              Vec3 bent;
              if (!refract(-wo, h, eta, bent) || bent.z >= 0) return;
              const double fresnel = fresnel_dielectric(std::clamp(dot(wo, h), 0.0, 1.0), eta);
              back += weight * (1 - fresnel) * ggx.shadowing(bent, wo) / ggx.masking(wo) *
                      coat_albedo(root * root, -bent.z);
            });
        return back;
      });
    }
  });
  return coats_;
}

template <typename Value>
double GlassAlbedo::between_coats(double coat_alpha, const Value& value_of) const {
  const std::vector<Grid>& grids = coats();
  const int steps = static_cast<int>(grids.size()) - 1;
  const double scaled = std::sqrt(std::clamp(coat_alpha, 0.0, 1.0)) * steps;
  const int step = std::min(static_cast<int>(scaled), steps - 1);
  const double rest = scaled - step;
  return value_of(grids[step]) * (1 - rest) + value_of(grids[step + 1]) * rest;
}

double GlassAlbedo::turned_back(double coat_alpha, double alpha, double cosine) const {
  return between_coats(coat_alpha, [&](const Grid& grid) { return grid.at(alpha, cosine); });
}

double GlassAlbedo::mean_turned_back(double coat_alpha, double alpha) const {
  return between_coats(coat_alpha, [&](const Grid& grid) { return grid.mean(alpha); });
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
