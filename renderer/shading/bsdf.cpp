#include "renderer/shading/bsdf.h"

#include <algorithm>

namespace tessera {
namespace {

Vec3 normal_of_lobes(const BsdfPoint& point) {
  if (!is_view_dependent(point.material)) return point.normal;
  return clamped_normal(point.normal, point.geometric_normal, point.wo);
}

}  // namespace

Bsdf::Bsdf(const BsdfPoint& point)
    : frame_(normal_of_lobes(point)),
      facet_normal_(point.geometric_normal),
      leans_(point.normal != point.geometric_normal),
      lobes_(lobes_of(point, frame_.to_local(point.wo),
                      frame_.z == point.normal ? Vec3{0, 0, 1} : frame_.to_local(point.normal))) {
  double sum = 0;
  for (size_t i = 0; i < lobes_.size(); ++i) {
    probabilities_[i] =
        std::visit([](const auto& lobe) { return lobe.sampling_weight(); }, lobes_[i]);
    sum += probabilities_[i];
    is_smooth_ |= std::visit([](const auto& lobe) { return !lobe.is_specular(); }, lobes_[i]);
  }
  if (!(sum > 0)) lobes_.clear();
  for (size_t i = 0; i < lobes_.size(); ++i) probabilities_[i] /= sum;
}

BsdfValue Bsdf::evaluate(const Vec3& world_wi) const {
  const double side = dot(world_wi, facet_normal_);
  if (side == 0) return {};
  return evaluate_on_side(frame_.to_local(world_wi), world_wi, side < 0);
}

BsdfValue Bsdf::evaluate_on_side(const Vec3& wi, const Vec3& world_wi, bool is_transmitted) const {
  BsdfValue value = evaluate_lobes(wi, is_transmitted);
  if (!leans_) return value;
  const Vec3 mirrored = frame_.to_local(reflect(world_wi, facet_normal_));
  const BsdfValue folded = evaluate_lobes(mirrored, is_transmitted);
  value.f_cosine += folded.f_cosine;
  value.density += folded.density;
  return value;
}

BsdfValue Bsdf::evaluate_lobes(const Vec3& wi, bool is_transmitted) const {
  BsdfValue value;
  for (size_t i = 0; i < lobes_.size(); ++i) {
    const BsdfValue one =
        std::visit([&](const auto& lobe) { return lobe.evaluate(wi, is_transmitted); }, lobes_[i]);
    value.f_cosine += one.f_cosine;
    value.density += probabilities_[i] * one.density;
  }
  return value;
}

bool Bsdf::sample(double choice, const Vec2& u, BsdfSample& sample) const {
  if (lobes_.empty()) return false;
  size_t chosen = 0;
  while (chosen + 1 < lobes_.size() && choice >= probabilities_[chosen])
    choice -= probabilities_[chosen++];
  const double probability = probabilities_[chosen];
  constexpr double kBelowOne = 0x1.fffffffffffffp-1;
  LobeSample way;
  if (!(probability > 0) || !std::visit(
                                [&](const auto& lobe) {
                                  sample.is_specular = lobe.is_specular();
                                  return lobe.sample(std::min(choice / probability, kBelowOne), u,
                                                     way);
                                },
                                lobes_[chosen]))
    return false;
  const Vec3 world_wi = frame_.from_local(way.wi);
  if (dot(world_wi, facet_normal_) == 0) return false;
  sample.is_transmitted = way.is_transmitted;
  sample.radiance_scale = way.radiance_scale;
  sample.wi = reflected_to_side(world_wi, facet_normal_, way.is_transmitted);
  if (sample.is_specular) {
    sample.weight = way.weight * (1 / probability);
    return true;
  }
  const BsdfValue value = evaluate_on_side(way.wi, world_wi, way.is_transmitted);
  if (!(value.density > 0)) return false;
  const bool cancels = lobes_.size() == 1 && !is_black(way.weight);
  sample.weight = cancels ? way.weight : value.f_cosine * (1 / value.density);
  sample.density = value.density;
  return true;
}

}  // namespace tessera
