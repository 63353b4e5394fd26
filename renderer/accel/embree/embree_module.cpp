#include "renderer/accel/embree/embree_module.h"

#include <dlfcn.h>

#include "base/program_folder.h"

namespace tessera {
namespace {

using SceneFactory = EmbreeScene* (*)(const float*, size_t, const uint32_t*, size_t, int);
using BoxesFactory = EmbreeBoxes* (*)(const std::array<float, 6>*, size_t, int);

void* load(const char* symbol) {
  static void* const module =
      dlopen((program_folder() / "tessera_embree.so").c_str(), RTLD_NOW | RTLD_LOCAL);
  return module ? dlsym(module, symbol) : nullptr;
}

}  // namespace

std::unique_ptr<EmbreeScene> make_embree_scene(std::span<const float> positions,
                                               std::span<const uint32_t> triangles, int threads) {
  const auto make = reinterpret_cast<SceneFactory>(load("tessera_make_embree_scene"));
  if (!make) return nullptr;
  return std::unique_ptr<EmbreeScene>(make(positions.data(), positions.size() / 3, triangles.data(),
                                           triangles.size() / 3, threads));
}

std::unique_ptr<EmbreeBoxes> make_embree_boxes(std::span<const std::array<float, 6>> boxes,
                                               int threads) {
  const auto make = reinterpret_cast<BoxesFactory>(load("tessera_make_embree_boxes"));
  if (!make) return nullptr;
  return std::unique_ptr<EmbreeBoxes>(make(boxes.data(), boxes.size(), threads));
}

}  // namespace tessera
