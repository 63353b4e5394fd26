#include "renderer/accel/accelerator.h"

#include <array>
#include <utility>

namespace tessera {
namespace {

constexpr std::array<std::pair<std::string_view, AcceleratorKind>, 6> kNames{{
    {"bvh", AcceleratorKind::bvh},
    {"bvh-splits", AcceleratorKind::bvh_splits},
    {"octree", AcceleratorKind::octree},
    {"nonuniform-octree", AcceleratorKind::nonuniform_octree},
    {"embree", AcceleratorKind::embree},
    {"linear", AcceleratorKind::linear},
}};

}  // namespace

std::optional<AcceleratorKind> parse_accelerator(std::string_view name) {
  for (const auto& [known, kind] : kNames)
    if (known == name) return kind;
  return std::nullopt;
}

std::string_view accelerator_name(AcceleratorKind kind) {
  for (const auto& [name, known] : kNames)
    if (known == kind) return name;
  return "unknown";
}

}  // namespace tessera
