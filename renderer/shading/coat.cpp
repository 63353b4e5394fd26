#include "renderer/shading/coat.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numeric>
#include <vector>

#include "renderer/shading/albedo_grid.h"
#include "renderer/shading/microfacet.h"

namespace tessera {

namespace {

/// Steps of the root of the coat's alpha.
constexpr int kCoats = 16;

constexpr int kAlphas = 16, kCosines = 24;
using FacetGrid = AlbedoGrid<double, kAlphas, kCosines>;
/// Means have no cosine left.
using MeanGrid = AlbedoGrid<CoatMeans, 16, 1>;

double coat_alpha_at(int step) {
  const double root = static_cast<double>(step) / kCoats;
  return root * root;
}

using Row = std::array<double, kCosines + 1>;
/// By the step of the root of alpha and that of the cosine of wo: what facets reflect from there to
/// the steps of the cosine of wi, 1 in all.
using Kernels = std::array<std::array<Row, kCosines + 1>, kAlphas + 1>;

std::unique_ptr<const Kernels> make_kernels(CoatedFacets kind) {
  auto kernels = std::make_unique<Kernels>();
  for (int a = 0; a <= kAlphas; ++a) {
    for (int c = 0; c <= kCosines; ++c) {
      Row& row = (*kernels)[a][c];
      row.fill(0);
      double sum = 0;
      for_each_visible_facet<8, 32>(
          static_cast<double>(a) / kAlphas, FacetGrid::cosine_at(c),
          [&](const Ggx& ggx, const Vec3& wo, const Vec3& h, double weight) {
            const Vec3 wi = h * (2 * dot(wo, h)) - wo;
            if (wi.z <= 0) return;
            const double fresnel = kind == CoatedFacets::white ? 1 : coat_albedo(0, dot(wo, h));
            const double kept = weight * fresnel * ggx.shadowing(wi, wo) / ggx.masking(wo);
            const FacetGrid::Step step = FacetGrid::step_at_cosine(wi.z);
            row[step.index] += kept * (1 - step.rest);
            row[step.index + 1] += kept * step.rest;
            sum += kept;
          });
      for (double& share : row) share /= sum;
    }
  }
  return kernels;
}

/// Which factor for facets loses nothing: g(wo) * the mean of g(wi), as the facets send light from
/// wo to wi, is to be 1 - E(wo) (Sinkhorn's scaling of a symmetric kernel).
FacetGrid facets_under(double coat_alpha, const Kernels& kernels) {
  Row passes;
  for (int c = 0; c <= kCosines; ++c) {
    passes[c] = 1 - coat_albedo(coat_alpha, FacetGrid::cosine_at(c));
  }
  std::array<Row, kAlphas + 1> factors;
  for (int a = 0; a <= kAlphas; ++a) {
    Row& g = factors[a];
    for (int c = 0; c <= kCosines; ++c) g[c] = std::sqrt(passes[c]);  // a mirror's
    constexpr int kTimes = 16;  // each halves what is left to mend
    for (int i = 0; i < kTimes; ++i) {
      Row better;
      for (int c = 0; c <= kCosines; ++c) {
        const Row& row = kernels[a][c];
        const double mean = std::inner_product(row.begin(), row.end(), g.begin(), 0.0);
        better[c] = std::sqrt(g[c] * passes[c] / mean);
      }
      g = better;
    }
  }
  return FacetGrid([&](double root_alpha, double cosine) {
    return factors[std::lround(root_alpha * kAlphas)][std::lround(std::sqrt(cosine) * kCosines)];
  });
}

MeanGrid means_under(double coat_alpha) {
  return MeanGrid([coat_alpha](double root_alpha, double) {
    constexpr int kParts = 256;
    CoatMeans sum;
    for (int i = 0; i < kParts; ++i) {
      const double cosine = (i + 0.5) / kParts;
      const FacetAlbedo facets = facet_albedo(root_alpha * root_alpha, cosine);
      const double share = 2 * cosine * coat_albedo(coat_alpha, cosine) / kParts;
      sum = sum + CoatMeans{1, facets.scale, facets.bias} * share;
    }
    return sum;
  });
}

struct Tables {
  std::array<std::vector<FacetGrid>, 2> facets;  ///< by kind, and the step of the coat's alpha
  std::vector<MeanGrid> means;
};

const Tables& tables() {
  static const Tables made = [] {
    Tables result;
    for (const CoatedFacets kind : {CoatedFacets::white, CoatedFacets::dielectric}) {
      const std::unique_ptr<const Kernels> kernels = make_kernels(kind);
      for (int i = 0; i <= kCoats; ++i) {
        result.facets[static_cast<int>(kind)].push_back(facets_under(coat_alpha_at(i), *kernels));
      }
    }
    for (int i = 0; i <= kCoats; ++i) result.means.push_back(means_under(coat_alpha_at(i)));
    return result;
  }();
  return made;
}

/// Linear in the root of the coat's alpha.
template <typename Value>
auto between_coats(double alpha, const Value& value_of) {
  const double scaled = std::sqrt(std::clamp(alpha, 0.0, 1.0)) * kCoats;
  const int step = std::min(static_cast<int>(scaled), kCoats - 1);
  const double rest = scaled - step;
  return value_of(step) * (1 - rest) + value_of(step + 1) * rest;
}

}  // namespace

double coat_albedo(double alpha, double cosine) {
  const Color f0 = kWhite * kCoatReflectance;
  return (alpha > 0 ? facet_albedo(alpha, cosine).of(f0) : fresnel_schlick(f0, cosine)).r;
}

double coated_facets(CoatedFacets kind, double alpha, double base_alpha, double cosine) {
  if (base_alpha == 0) return std::sqrt(1 - coat_albedo(alpha, cosine));
  const std::vector<FacetGrid>& facets = tables().facets[static_cast<int>(kind)];
  return between_coats(alpha, [&](int i) { return facets[i].at(base_alpha, cosine); });
}

CoatMeans coat_means(double alpha, double base_alpha) {
  const Tables& made = tables();
  return between_coats(alpha, [&](int i) { return made.means[i].at(base_alpha, 1); });
}

}  // namespace tessera
