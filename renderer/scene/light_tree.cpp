#include "renderer/scene/light_tree.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "renderer/shapes/light_halves.h"

namespace tessera {

namespace {

/// What lies wholly behind the point keeps this share of it, for surfaces that let light through
/// and normals that are not the true ones.
constexpr double kBehind = 0.02;

/// A bound on the cosine at the point of all directions to the ball.
double cosine_bound(const Vec3& way, double squared, double radius, const Vec3& n) {
  if (squared <= radius * radius) return 1;
  const double cosine = dot(way, n) / std::sqrt(squared);
  const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  const double ball_sine = radius / std::sqrt(squared);
  const double ball_cosine = std::sqrt(std::max(0.0, 1 - ball_sine * ball_sine));
  // Nearer to the normal by the ball's own angle, if it does not hold the normal.
  const double bound = cosine >= ball_cosine ? 1 : cosine * ball_cosine + sine * ball_sine;
  return std::max(bound, kBehind);
}

}  // namespace

LightTree::LightTree(const std::vector<Light>& lights) : leaves_(lights.size()) {
  if (lights.empty()) return;
  std::vector<uint32_t> order(lights.size());
  std::iota(order.begin(), order.end(), 0u);
  nodes_.reserve(2 * lights.size());
  build(lights, order, 0, lights.size(), 0);
}

uint32_t LightTree::build(const std::vector<Light>& lights, std::vector<uint32_t>& order,
                          size_t from, size_t to, uint32_t parent) {
  const auto index = static_cast<uint32_t>(nodes_.size());
  nodes_.emplace_back();
  Bounds3 box;
  double power = 0;
  for (size_t i = from; i < to; ++i) {
    box.extend(lights[order[i]].bounds);
    power += lights[order[i]].power;
  }
  Node node;
  node.center = box.center();
  node.radius = length(box.diagonal()) / 2;
  node.power = power;
  node.parent = parent;
  if (to - from == 1) {
    node.light = order[from];
    leaves_[order[from]] = index;
    nodes_[index] = node;
    return index;
  }
  // Halves: lights are few beside what they light.
  halve(std::span(order).subspan(from, to - from),
        [&](uint32_t light) { return lights[light].bounds.center(); });
  const size_t middle = from + (to - from) / 2;
  nodes_[index] = node;
  build(lights, order, from, middle, index);
  nodes_[index].right = build(lights, order, middle, to, index);
  return index;
}

double LightTree::share_of_first(const Node& node, uint32_t index, const Point3& p,
                                 const Vec3& n) const {
  const auto worth = [&](const Node& child) {
    const Vec3 way = child.center - p;
    const double squared = length_squared(way);
    const double near = std::max(squared, child.radius * child.radius);
    return near > 0 ? child.power * cosine_bound(way, squared, child.radius, n) / near
                    : child.power;
  };
  return first_share(worth(nodes_[index + 1]), worth(nodes_[node.right]));
}

LightTree::Pick LightTree::pick(const Point3& p, const Vec3& n, double u) const {
  Pick pick;
  uint32_t index = 0;
  while (nodes_[index].right != 0) {
    const double share = share_of_first(nodes_[index], index, p, n);
    if (chooses_first(share, u)) {
      pick.probability *= share;
      ++index;
    } else {
      pick.probability *= 1 - share;
      index = nodes_[index].right;
    }
  }
  pick.index = nodes_[index].light;
  return pick;
}

double LightTree::probability(const Point3& p, const Vec3& n, uint32_t light) const {
  double probability = 1;
  for (uint32_t index = leaves_[light]; index != 0;) {
    const uint32_t parent = nodes_[index].parent;
    const double share = share_of_first(nodes_[parent], parent, p, n);
    probability *= index == parent + 1 ? share : 1 - share;
    index = parent;
  }
  return probability;
}

}  // namespace tessera
