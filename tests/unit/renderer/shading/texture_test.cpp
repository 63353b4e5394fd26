#include "renderer/shading/texture.h"

#include <gtest/gtest.h>

#include <cmath>

#include "renderer/shading/material_inputs.h"
#include "renderer/shading/microfacet.h"
#include "renderer/shading/noise.h"

namespace tessera {
namespace {

TexturePoint at_uv(double u, double v, double width = 0) {
  TexturePoint point;
  point.uv = {{u, v, 0}, {width, 0, 0}, {0, width, 0}};
  return point;
}

TexturePoint at_object(const Vec3& p) {
  TexturePoint point;
  point.object.at = p;
  return point;
}

Color value(const Texture& texture, const TexturePoint& point) {
  return look_up(texture, point, {}).color;
}

TEST(Noise, is_zero_on_the_lattice_and_within_its_bounds) {
  double largest = 0;
  for (int i = 0; i < 4000; ++i) {
    const double x = std::fmod(i * 0.754877666, 1) * 40 - 20,
                 y = std::fmod(i * 0.569840291, 1) * 40, z = i * 0.01;
    EXPECT_EQ(gradient_noise({std::floor(x), std::floor(y), std::floor(z)}), 0);
    largest = std::max(largest, std::abs(gradient_noise({x, y, z})));
  }
  EXPECT_GT(largest, .6);
  EXPECT_LE(largest, 1);
}

TEST(Noise, is_smooth_across_cells_and_never_repeats) {
  for (const double h : {1e-4, 1e-6}) {
    const Vec3 p{3, .3, -.7};
    const double slope_left = gradient_noise(p) - gradient_noise(p - Vec3{h, 0, 0});
    const double slope_right = gradient_noise(p + Vec3{h, 0, 0}) - gradient_noise(p);
    EXPECT_NEAR(slope_left / h, slope_right / h, 20 * h);
  }
  EXPECT_NE(gradient_noise({.3, .4, .5}), gradient_noise({256.3, .4, .5}));
}

TEST(Noise, has_the_same_bits_everywhere) {
  EXPECT_EQ(gradient_noise({.5, .5, .5}), 0.25);
  EXPECT_EQ(fractal_noise({1.3, -7.7, 3.1}, 4, 0), 0.29029560306936308);
  EXPECT_EQ(turbulence({1.3, -7.7, 3.1}, 4, 0), 0.61671210288458189);
}

TEST(Noise, fades_what_is_finer_than_the_patch) {
  const Vec3 p{.3, .4, .6};
  EXPECT_EQ(fractal_noise(p, 3, .25), gradient_noise(p) + gradient_noise(p * 2) / 2);
  EXPECT_EQ(fractal_noise(p, 9, 1), 0);
  EXPECT_NEAR(turbulence(p, 9, 1), .4399, .001);  // the mean of |noise|, times 2 - 2^-8
}

TEST(Texture, checkers_alternate_in_space) {
  const Texture solid{.kind = TextureKind::checker, .mapping = TextureMapping::object};
  EXPECT_EQ(value(solid, at_object({.5, .5, .5})), kWhite);
  EXPECT_EQ(value(solid, at_object({1.5, .5, .5})), kBlack);
  EXPECT_EQ(value(solid, at_object({1.5, .5, -.5})), kWhite);
  EXPECT_EQ(value(solid, at_object({-.5, .5, .5})), kBlack);
  const Texture flat{.kind = TextureKind::checker};
  EXPECT_EQ(value(flat, at_uv(.5, 1.5)), kBlack);
}

TEST(Texture, checkers_are_averaged_over_the_patch) {
  const Texture flat{.kind = TextureKind::checker};
  EXPECT_NEAR(value(flat, at_uv(1, .5, .5)).r, .5, 1e-12);      // astride an edge
  EXPECT_NEAR(value(flat, at_uv(.875, .5, .5)).r, .75, 1e-12);  // three quarters in the even cell
  EXPECT_EQ(value(flat, at_uv(.5, .5, .9)).r, 1);
  EXPECT_NEAR(value(flat, at_uv(.3, .7, 2)).r, .5, 1e-12);
  EXPECT_EQ(value(flat, at_uv(.3, .7, 1e300)).r, .5);
}

TEST(Texture, a_checker_may_hold_textures) {
  std::vector<Texture> all(2);
  all[0].positions = {0, 1};
  all[0].colors = {kBlack, {0, 1, 0}};
  all[1].kind = TextureKind::checker;
  all[1].even = {{.5, .5, .5}, 0};
  EXPECT_EQ(look_up(all[1], at_uv(.5, .5), all).color, (Color{0, .25, 0}));
}

TEST(Texture, gradients_are_linear_and_end) {
  Texture ramp;
  ramp.positions = {.25, .75};
  ramp.colors = {{1, 0, 0}, {0, 0, 1}};
  EXPECT_EQ(value(ramp, at_uv(.5, 9)), (Color{.5, 0, .5}));
  EXPECT_EQ(value(ramp, at_uv(0, 0)), (Color{1, 0, 0}));
  EXPECT_EQ(value(ramp, at_uv(.75, 0)), (Color{0, 0, 1}));
  ramp.transform = scaling({2, 1, 1});
  EXPECT_EQ(value(ramp, at_uv(.25, 9)), (Color{.5, 0, .5}));
}

TEST(Texture, noises_mix_two_colours) {
  Texture noise{.kind = TextureKind::noise, .mapping = TextureMapping::object};
  const Vec3 p{.3, .4, .6};
  noise.frequency = 2;
  EXPECT_EQ(value(noise, at_object(p)).r, (1 + gradient_noise(p * 2)) / 2);
  noise.noise = NoiseKind::marble;
  noise.strength = 0;
  noise.frequency = 1;
  EXPECT_NEAR(value(noise, at_object({.25, 3, 3})).r, 1, 1e-15);
  EXPECT_NEAR(value(noise, at_object({-.25, 3, 3})).r, 0, 1e-15);
  noise.noise = NoiseKind::wood;
  EXPECT_NEAR(value(noise, at_object({.3, 9, .4})).r, .5, 1e-15);
  noise.noise = NoiseKind::turbulence;
  noise.strength = 100;
  EXPECT_EQ(value(noise, at_object(p)).r, 1);  // clamped
}

TEST(Texture, maps_by_the_normal) {
  Texture ramp;
  ramp.mapping = TextureMapping::object_normal;
  ramp.positions = {0, 1};
  ramp.colors = {kBlack, kWhite};
  TexturePoint point;
  point.object_normal = {.5, 0, 0};
  EXPECT_EQ(value(ramp, point).r, .75);
  ramp.mapping = TextureMapping::view_normal;
  point.view_normal = {-1, 0, 0};
  EXPECT_EQ(value(ramp, point).r, 0);
}

TEST(Relief, a_ramp_of_heights_tilts_the_normal) {
  // The height grows by .5 a metre along u; a metre is half a unit of u.
  std::vector<Texture> all(1);
  all[0].positions = {0, 1};
  all[0].colors = {kBlack, kWhite};
  MaterialInputs inputs;
  inputs.bump = 0;
  inputs.bump_height = 1;
  const SurfaceFrame frame{{0, 0, 1}, {2, 0, 0}, {0, 2, 0}};
  const Vec3 n = perturbed_normal(inputs, at_uv(.5, .5), all, frame, Affine{}, .01);
  const Vec3 expected = normalize(Vec3{-.5, 0, 1});
  EXPECT_NEAR(length(n - expected), 0, 1e-12);
  // Without texture coordinates there is no direction to tilt to.
  EXPECT_EQ(perturbed_normal(inputs, at_uv(.5, .5), all, {{0, 0, 1}, {}, {}}, Affine{}, .01),
            (Vec3{0, 0, 1}));
}

TEST(Relief, normal_maps_turn_with_the_surface) {
  std::vector<Texture> all(1);
  all[0].positions = {0};
  all[0].colors = {{1, .5, .5}};  // along +u
  MaterialInputs inputs;
  inputs.normal_map = 0;
  const SurfaceFrame frame{{0, 0, 1}, {0, 3, 0}, {-3, 0, 0}};
  EXPECT_NEAR(length(perturbed_normal(inputs, {}, all, frame, Affine{}, 1) - Vec3{0, 1, 0}), 0,
              1e-15);
  all[0].colors = {{.5, 1, 1}};  // between +v and the normal
  const Vec3 n = perturbed_normal(inputs, {}, all, frame, Affine{}, 1);
  EXPECT_NEAR(length(n - normalize(Vec3{-1, 0, 1})), 0, 1e-15);
  inputs.normal_scale = 0;
  EXPECT_EQ(perturbed_normal(inputs, {}, all, frame, Affine{}, 1), (Vec3{0, 0, 1}));
}

TEST(Relief, normal_maps_lie_along_given_tangents) {
  std::vector<Texture> all(1);
  all[0].positions = {0};
  all[0].colors = {{.5, 1, .5}};  // along the bitangent
  MaterialInputs inputs;
  inputs.normal_map = 0;
  for (const double side : {1., -1.}) {
    const SurfaceFrame frame{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {0, 2, 0}, {-side, 0, 0}};
    const Vec3 n = perturbed_normal(inputs, {}, all, frame, Affine{}, 1);
    EXPECT_NEAR(length(n - Vec3{-side, 0, 0}), 0, 1e-15) << "in place of u and v";
  }
}

TEST(Microfacets, reflect_as_much_as_they_should) {
  // Over the hemisphere the microfacets' normals add up to the surface: the integral of D (n.h).
  for (const double alpha : {.1, .5, 1.0}) {
    double sum = 0;
    constexpr int kSteps = 20000;
    for (int i = 0; i < kSteps; ++i) {
      const double theta = (i + .5) / kSteps * std::acos(-1) / 2;
      const Vec3 n{0, 0, 1}, h{std::sin(theta), 0, std::cos(theta)};
      // With wi = wo = h the share is pi D V, V being Smith's visibility.
      const double a2 = alpha * alpha, c = h.z;
      const double visibility = .25 / (c * std::sqrt(a2 + (1 - a2) * c * c));
      const double d = microfacet_share(alpha, n, h, h, h) / (std::acos(-1) * visibility);
      sum += d * c * std::sin(theta) * 2 * std::acos(-1) * (std::acos(-1) / 2 / kSteps);
    }
    EXPECT_NEAR(sum, 1, 1e-5) << alpha;
  }
}

TEST(Fresnel, conductors) {
  // At normal incidence ((n - 1)^2 + k^2) / ((n + 1)^2 + k^2); with k = 0, a dielectric's.
  const Color gold = fresnel_conductor(1, {.18, .42, 1.37}, {3.42, 2.35, 1.77});
  EXPECT_NEAR(gold.r, (.82 * .82 + 3.42 * 3.42) / (1.18 * 1.18 + 3.42 * 3.42), 1e-12);
  EXPECT_NEAR(gold.b, (.37 * .37 + 1.77 * 1.77) / (2.37 * 2.37 + 1.77 * 1.77), 1e-12);
  for (const double c : {.05, .4, .9}) {
    EXPECT_NEAR(fresnel_conductor(c, kWhite * 1.5, kBlack).g, fresnel_dielectric(c, 1.5), 1e-12);
  }
  EXPECT_NEAR(fresnel_conductor(0, kWhite, kWhite).r, 1, 1e-12);
  EXPECT_EQ(fresnel_schlick(kWhite * .04, 1).r, .04);
  EXPECT_EQ(fresnel_schlick(kWhite * .04, 0).r, 1);
}

}  // namespace
}  // namespace tessera
