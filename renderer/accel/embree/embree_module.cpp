#include "renderer/accel/embree/embree_module.h"

#include <dlfcn.h>

#include <filesystem>

namespace tessera {
namespace {

using Factory = EmbreeScene* (*)(const float*, size_t, const uint32_t*, size_t, int);

Factory load_factory() {
  std::error_code failed;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", failed);
  if (failed) return nullptr;
  const auto path = program.parent_path() / "tessera_embree.so";
  void* module = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!module) return nullptr;
  return reinterpret_cast<Factory>(dlsym(module, "tessera_make_embree_scene"));
}

}  // namespace

std::unique_ptr<EmbreeScene> make_embree_scene(std::span<const float> positions,
                                               std::span<const uint32_t> triangles, int threads) {
  static const Factory factory = load_factory();
  if (!factory) return nullptr;
  return std::unique_ptr<EmbreeScene>(factory(positions.data(), positions.size() / 3,
                                              triangles.data(), triangles.size() / 3, threads));
}

}  // namespace tessera
