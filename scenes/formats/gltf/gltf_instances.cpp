#include "scenes/formats/gltf/gltf_instances.h"

#include <fmt/format.h>

#include "scenes/formats/gltf/gltf_accessor.h"
#include "scenes/formats/gltf/gltf_transform.h"

namespace tessera {

std::optional<std::vector<Affine>> read_gltf_instances(GltfFile& file, const GltfValue& node) {
  constexpr std::string_view kTaken = "the mesh is shown once";
  constexpr double kRounding = 1. / 64;  // of the four bytes of a quaternion
  constexpr uint64_t kCost = 1024;       // numbers' worth of memory that an instance takes, about
  const GltfValue in = node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
  if (!in) return std::nullopt;
  std::optional<size_t> count;
  bool is_whole = true;
  const auto rows = [&](const char* key, size_t width) {
    const GltfValue reference = in[key];
    if (!reference || !is_whole) return std::vector<float>{};
    const auto from = GltfAccessor::read(file, reference, kTaken);
    is_whole = from.has_value();
    if (!from) return std::vector<float>{};
    if (from->components() != width)
      throw reference.error(fmt::format("rows of {}", from->components()),
                            fmt::format("{} numbers a row", width));
    if (count.value_or(from->count()) != from->count())
      throw reference.error(fmt::format("{} rows", from->count()),
                            fmt::format("{}, as of the others", *count));
    if (!count) file.spend(from->count() * kCost, reference);
    count = from->count();
    return from->floats(0, *count, width);
  };
  std::vector<Affine> out;
  is_whole &= file.attempt(kTaken, [&] {
    const std::vector<float> shifts = rows("TRANSLATION", 3), turns = rows("ROTATION", 4),
                             sizes = rows("SCALE", 3);
    if (is_whole && !count) throw in.error("no attribute", "TRANSLATION, ROTATION or SCALE");
    for (size_t i = 0; is_whole && i < *count; ++i) {
      Affine frame;
      if (!shifts.empty())
        frame = translation({shifts[i * 3], shifts[i * 3 + 1], shifts[i * 3 + 2]});
      if (!turns.empty()) {
        const auto begin = turns.begin() + static_cast<std::ptrdiff_t>(i * 4);
        frame =
            frame * gltf_rotation(std::vector<double>(begin, begin + 4), in["ROTATION"], kRounding);
      }
      if (!sizes.empty())
        frame = frame * scaling({sizes[i * 3], sizes[i * 3 + 1], sizes[i * 3 + 2]});
      if (is_finite(frame))
        out.push_back(frame);
      else
        in.repair("an instance whose frame is not finite", "finite numbers", "it is left out");
    }
  });
  if (!is_whole) return std::nullopt;
  return out;
}

}  // namespace tessera
