// A scene whose numbers are extreme: meshes, round shapes, instances and lights, made from the
// bytes themselves, since no reader would let random bytes so far. Whatever the numbers, every
// accelerator builds, and all give one picture.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "tests/fuzz/render_fuzzed.h"

namespace {

using namespace tessera;

/// Takes numbers off the input; at its end all are 0.
class Numbers {
 public:
  explicit Numbers(std::span<const uint8_t> data) : data_(data) {}

  bool is_at_end() const { return data_.empty(); }
  uint8_t byte() {
    if (data_.empty()) return 0;
    const uint8_t first = data_.front();
    data_ = data_.subspan(1);
    return first;
  }
  /// A byte below 0x40 stands for an extreme, one below 0x80 for an eighth of its distance from
  /// 0x60; behind any other come four bytes, a little-endian float. What is not finite counts as 0:
  /// no scene with it is built.
  double number() {
    static constexpr double kExtremes[] = {
        0,       -0.0,     1e-45,  -1e-45,  1.2e-38, 1e-30,   1e-19,          -1e-19,
        1e19,    -1e19,    1e30,   -1e30,   1e37,    -1e37,   1e38,           -1e38,
        2e38,    -2e38,    2.5e38, -2.5e38, 3.4e38,  -3.4e38, 0x1.fffffep127, -0x1.fffffep127,
        1e39,    -1e39,    1e100,  -1e100,  1e150,   1e154,   -1e155,         1e300,
        1.7e308, -1.7e308, 5e-324, 1e-310,  1e-160,  0x1p24,  16777217,       1e9};
    const uint8_t code = byte();
    if (code < 0x40) return kExtremes[code % std::size(kExtremes)];
    if (code < 0x80) return (code - 0x60) / 8.0;
    uint8_t bytes[4];
    for (uint8_t& b : bytes) b = byte();
    float value;
    std::memcpy(&value, bytes, sizeof value);
    return std::isfinite(value) ? value : 0;
  }
  template <typename Vector>
  void vector(Vector* v) {
    v->set_x(number());
    v->set_y(number());
    v->set_z(number());
  }

 private:
  std::span<const uint8_t> data_;
};

template <typename Value>
void put(BlobStore& blobs, const std::vector<Value>& values, v1::BlobRef* ref) {
  std::vector<std::byte> bytes(values.size() * sizeof(Value));
  if (!bytes.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  ref->set_size(bytes.size());
  ref->set_digest(blobs.put(std::move(bytes)).hex());
}

/// Triangles that share no corner, or strips in which each shares two with the one before.
void add_mesh(Numbers& numbers, BlobStore& blobs, v1::Shape* shape) {
  const uint8_t kind = numbers.byte();
  const size_t triangles = 1 + numbers.byte();
  const bool is_strip = (kind & 1) != 0;
  std::vector<uint32_t> indices;
  for (uint32_t i = 0; i < triangles; ++i)
    for (uint32_t k = 0; k < 3; ++k) indices.push_back(is_strip ? i + k : 3 * i + k);
  constexpr double kMost = std::numeric_limits<float>::max();
  std::vector<float> positions;
  const size_t vertices = is_strip ? triangles + 2 : 3 * triangles;
  for (size_t i = 0; i < 3 * vertices; ++i)
    positions.push_back(static_cast<float>(std::clamp(numbers.number(), -kMost, kMost)));
  put(blobs, positions, shape->mutable_mesh()->mutable_positions());
  put(blobs, indices, shape->mutable_mesh()->mutable_triangles());
  if (kind & 2) shape->add_materials("glowing");
}

void add_shape(Numbers& numbers, uint8_t kind, BlobStore& blobs, v1::Shape* shape) {
  switch (kind) {
    case 0:
    case 1:
      return add_mesh(numbers, blobs, shape);
    case 2:
      numbers.vector(shape->mutable_sphere()->mutable_center());
      return shape->mutable_sphere()->set_radius(numbers.number());
    case 3:
      numbers.vector(shape->mutable_box()->mutable_min());
      return numbers.vector(shape->mutable_box()->mutable_max());
    case 4:
      shape->mutable_torus()->set_major_radius(numbers.number());
      return shape->mutable_torus()->set_minor_radius(numbers.number());
    case 5:
      shape->mutable_cylinder()->set_radius(numbers.number());
      return shape->mutable_cylinder()->set_height(numbers.number());
    default: {
      v1::Csg* const csg = shape->mutable_csg();
      csg->set_operation(v1::Csg::DIFFERENCE);
      for (int i = 0; i < 2; ++i)
        add_shape(numbers, static_cast<uint8_t>(2 + numbers.byte() % 4), blobs,
                  csg->add_operands()->mutable_shape());
    }
  }
}

void add_transform(Numbers& numbers, v1::Transform* transform) {
  numbers.vector(transform->add_steps()->mutable_translate());
  v1::AxisAngle* const turn = transform->add_steps()->mutable_rotate();
  numbers.vector(turn->mutable_axis());
  turn->set_angle(numbers.number());
  numbers.vector(transform->add_steps()->mutable_scale());
}

void add_node(Numbers& numbers, BlobStore& blobs, v1::Scene& scene) {
  const uint8_t kind = numbers.byte();
  const bool is_object = (kind & 0x40) != 0;
  v1::Node* node = nullptr;
  if (is_object) {
    v1::Object* const object = scene.add_objects();
    object->set_name(std::to_string(scene.objects_size()));
    node = object->add_nodes();
  } else {
    node = scene.add_nodes();
  }
  if (kind & 0x80) add_transform(numbers, node->mutable_transform());
  switch (const uint8_t what = kind % 16; what) {
    case 7:
      return numbers.vector(node->mutable_light()->mutable_point()->mutable_position());
    case 8:
      return numbers.vector(node->mutable_light()->mutable_directional()->mutable_direction());
    case 9:
    case 10:
    case 11:
      return node->set_instance_of(std::to_string(1 + numbers.byte() % 4));
    default:
      return add_shape(numbers, static_cast<uint8_t>(what % 7), blobs, node->mutable_shape());
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  Numbers numbers({data, size});
  v1::Scene scene;
  BlobStore blobs;
  v1::Material* const material = scene.add_materials();
  material->set_name("glowing");
  material->mutable_classic()->mutable_emission()->mutable_value()->set_r(1);
  const uint8_t kind = numbers.byte();
  if (kind & 1) {
    v1::LookAt* const view =
        scene.add_cameras()->mutable_world_from_camera()->add_steps()->mutable_look_at();
    numbers.vector(view->mutable_eye());
    numbers.vector(view->mutable_target());
  }
  constexpr int kMostNodes = 16;
  for (int i = 0; i < kMostNodes && !numbers.is_at_end(); ++i) add_node(numbers, blobs, scene);
  render_fuzzed(scene, blobs, (kind & 2) != 0);
  return 0;
}
