#include "tests/fuzz/render_fuzzed.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "renderer/accel/embree/embree_module.h"
#include "renderer/render/tile_renderer.h"

namespace tessera {

namespace {

// Bounds on what is rendered, so that an input takes milliseconds.
constexpr size_t kMostNodes = 64;       ///< with all that instances show
constexpr size_t kMostTriangles = 400;  ///< of all instances together
constexpr size_t kMostBlobBytes = size_t{1} << 18;
constexpr uint32_t kMostDepth = 3;
constexpr int kPadding = 25;   ///< more than are scanned without a tree
constexpr uint32_t kSide = 5;  ///< of the frame, in pixels: fills no packet of rays

/// What a scene unfolds to, counted up to the bounds.
class SceneSize {
 public:
  explicit SceneSize(const v1::Scene& scene) {
    for (const v1::Object& object : scene.objects()) objects_[object.name()] = &object;
    add(scene.nodes());
  }
  bool is_small() const { return nodes_ <= kMostNodes && triangles_ <= kMostTriangles; }

 private:
  template <typename Nodes>
  void add(const Nodes& nodes) {
    for (const v1::Node& node : nodes) {
      // Counts each node before what is inside, so that a cycle ends.
      ++nodes_;
      if (!is_small()) return;
      add(node.shape());
      const auto object = objects_.find(node.instance_of());
      if (object != objects_.end()) add(object->second->nodes());
      add(node.children());
    }
  }
  void add(const v1::Shape& shape) {
    const v1::TriangleMesh& mesh = shape.mesh();
    triangles_ += mesh.triangles().size() / 12 + mesh.positions().size() / 36;
    triangles_ += static_cast<size_t>(mesh.inline_triangles_size() + mesh.inline_positions_size());
    add(shape.csg().operands());
  }

  std::map<std::string, const v1::Object*> objects_;
  size_t nodes_ = 0, triangles_ = 0;
};

bool is_small(const v1::Scene& scene, const BlobStore& blobs) {
  size_t bytes = 0;
  for (const auto& [digest, blob] : blobs.all()) bytes += blob->size();
  return bytes <= kMostBlobBytes && SceneSize(scene).is_small();
}

/// Leaves out what takes long, and what a reader leaves to others: included files are not there,
/// and each picture is a single texel.
void make_ready(v1::Scene& scene, BlobStore& blobs) {
  scene.clear_includes();
  for (v1::Texture& texture : *scene.mutable_textures()) {
    if (!texture.has_image() || texture.image().width() > 0) continue;
    v1::Texture::Image& image = *texture.mutable_image();
    image.set_width(1);
    image.set_height(1);
    image.set_channels(3);
    image.set_bits(8);
    image.set_levels(1);
    const std::vector<std::byte> grey(3, std::byte{128});
    image.mutable_texels()->set_size(grey.size());
    image.mutable_texels()->set_digest(blobs.put(grey).hex());
  }
  v1::Settings& settings = *scene.mutable_settings();
  settings.clear_sampling();
  settings.clear_accelerator();
  v1::IntegratorSettings& integrator = *settings.mutable_integrator();
  integrator.clear_kind();
  integrator.set_max_depth(integrator.has_max_depth() ? std::min(integrator.max_depth(), kMostDepth)
                                                      : kMostDepth);
  for (v1::Camera& camera : *scene.mutable_cameras())
    if (camera.has_lens()) camera.mutable_lens()->clear_samples();
  if (scene.cameras().empty()) {
    v1::Camera& camera = *scene.add_cameras();
    camera.set_frame_all(true);
    camera.mutable_headlight()->mutable_directional()->mutable_direction()->set_z(-1);
  }
}

/// Adds spheres, so that there are enough instances for a tree.
void pad(v1::Scene& scene) {
  for (int i = 0; i < kPadding; ++i) {
    v1::Sphere& sphere = *scene.add_nodes()->mutable_shape()->mutable_sphere();
    sphere.mutable_center()->set_x(3 * (i % 5) - 6);
    sphere.mutable_center()->set_y(3 * (i / 5) - 6);
    sphere.mutable_center()->set_z(-20);
  }
}

/// The frame's values; nothing where the scene is refused.
std::optional<std::vector<float>> picture(const v1::Scene& scene, const BlobStore& blobs,
                                          const char* accelerator, const char* integrator) {
  v1::FrameSettings frame;
  frame.set_width(kSide);
  frame.set_height(kSide);
  frame.set_samples_per_pixel(1);
  frame.set_accelerator(accelerator);
  frame.set_integrator(integrator);
  try {
    const auto renderer = make_tile_renderer(scene, blobs, frame, 1);
    TileProgress progress;
    const auto tile = renderer->render({{0, 0, kSide, kSide}, 0, 1}, progress);
    return tile ? std::optional(tile->values) : std::nullopt;
  } catch (const Error&) {
    return std::nullopt;  // how a wrong scene is refused
  }
}

bool is_equal(const std::optional<std::vector<float>>& a,
              const std::optional<std::vector<float>>& b) {
  if (a.has_value() != b.has_value()) return false;
  return !a || (a->size() == b->size() &&
                std::memcmp(a->data(), b->data(), a->size() * sizeof(float)) == 0);
}

bool has_embree() {
  static const bool found = [] {
    const std::array<float, 6> box{0, 0, 0, 1, 1, 1};
    return make_embree_boxes({&box, 1}, 1) != nullptr;
  }();
  return found;
}

}  // namespace

void render_fuzzed(v1::Scene scene, BlobStore blobs, bool with_embree) {
  if (!is_small(scene, blobs)) return;
  make_ready(scene, blobs);
  spdlog::set_level(spdlog::level::off);  // of what a scene leaves out
  v1::Scene padded = scene;
  pad(padded);
  for (const char* integrator : {"whitted", "path"}) {
    const auto expected = picture(scene, blobs, "linear", integrator);
    if (expected && !std::ranges::all_of(*expected, [](float v) { return std::isfinite(v); })) {
      std::fprintf(stderr, "%s: a value that is not finite\n", integrator);
      std::abort();
    }
    const auto expect_same = [&](const v1::Scene& shown, const char* accelerator,
                                 const std::optional<std::vector<float>>& by_scan) {
      if (is_equal(picture(shown, blobs, accelerator, integrator), by_scan)) return;
      std::fprintf(stderr, "%s: another picture by %s%s than by the linear scan\n", integrator,
                   accelerator, &shown == &padded ? " of the padded scene" : "");
      std::abort();
    };
    expect_same(scene, "bvh", expected);
    const auto expected_padded = picture(padded, blobs, "linear", integrator);
    for (const char* accelerator : {"bvh", "bvh-splits", "octree", "nonuniform-octree"})
      expect_same(padded, accelerator, expected_padded);
    if (with_embree && has_embree()) expect_same(padded, "embree", expected_padded);
  }
}

}  // namespace tessera
