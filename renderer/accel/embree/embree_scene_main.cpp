// The module: the only code that links Embree. Loaded by make_embree_scene().
#include <embree3/rtcore.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <limits>
#include <string>

#include "renderer/accel/embree/counting_device.h"
#include "renderer/accel/embree/embree_module.h"

namespace tessera {
namespace {

RTCRay to_embree(const EmbreeRay& ray) {
  RTCRay r;
  r.org_x = ray.origin[0], r.org_y = ray.origin[1], r.org_z = ray.origin[2];
  r.dir_x = ray.direction[0], r.dir_y = ray.direction[1], r.dir_z = ray.direction[2];
  r.tnear = 0, r.tfar = ray.t_max, r.time = 0, r.mask = 0xffffffffu, r.id = 0, r.flags = 0;
  return r;
}

class Scene final : public EmbreeScene {
 public:
  Scene(const float* positions, size_t vertices, const uint32_t* triangles, size_t count,
        int threads) {
    device_ = new_counting_device(threads, bytes_);
    scene_ = rtcNewScene(device_);
    RTCGeometry mesh = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    void* to =
        rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, vertices);
    std::memcpy(to, positions, vertices * 12);
    to = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, count);
    std::memcpy(to, triangles, count * 12);
    rtcCommitGeometry(mesh);
    rtcAttachGeometry(scene_, mesh);
    rtcReleaseGeometry(mesh);
    const ssize_t before = bytes_;
    const auto start = std::chrono::steady_clock::now();
    rtcCommitScene(scene_);
    build_seconds_ =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    tree_bytes_ = static_cast<size_t>(bytes_ - before);
  }
  ~Scene() override {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }

  void closest_hits(std::span<EmbreeRay> rays) const override {
    for (EmbreeRay& ray : rays) {
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      RTCRayHit r;
      r.ray = to_embree(ray);
      r.hit.geomID = r.hit.primID = r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
      rtcIntersect1(scene_, &context, &r);
      ray.t = r.ray.tfar;
      ray.primitive = r.hit.geomID == RTC_INVALID_GEOMETRY_ID ? kNothing : r.hit.primID;
    }
  }
  void closest_hits_by_eights(std::span<EmbreeRay> rays) const override {
    for (size_t begin = 0; begin < rays.size(); begin += 8) {
      const size_t count = std::min<size_t>(8, rays.size() - begin);
      alignas(32) int valid[8];
      RTCRayHit8 r;
      for (size_t i = 0; i < 8; ++i) {
        const EmbreeRay& from = rays[begin + (i < count ? i : 0)];
        valid[i] = i < count ? -1 : 0;
        r.ray.org_x[i] = from.origin[0], r.ray.org_y[i] = from.origin[1];
        r.ray.org_z[i] = from.origin[2], r.ray.dir_x[i] = from.direction[0];
        r.ray.dir_y[i] = from.direction[1], r.ray.dir_z[i] = from.direction[2];
        r.ray.tnear[i] = 0, r.ray.tfar[i] = from.t_max, r.ray.time[i] = 0;
        r.ray.mask[i] = 0xffffffffu, r.ray.id[i] = 0, r.ray.flags[i] = 0;
        r.hit.geomID[i] = r.hit.primID[i] = r.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
      }
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
      rtcIntersect8(valid, scene_, &context, &r);
      for (size_t i = 0; i < count; ++i) {
        rays[begin + i].t = r.ray.tfar[i];
        rays[begin + i].primitive =
            r.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID ? kNothing : r.hit.primID[i];
      }
    }
  }
  void any_hits(std::span<EmbreeRay> rays) const override {
    for (EmbreeRay& ray : rays) {
      RTCIntersectContext context;
      rtcInitIntersectContext(&context);
      RTCRay r = to_embree(ray);
      rtcOccluded1(scene_, &context, &r);
      ray.primitive = r.tfar < 0 ? 0 : kNothing;
    }
  }
  double build_seconds() const override { return build_seconds_; }
  size_t bytes() const override { return tree_bytes_; }

 private:
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
  std::atomic<ssize_t> bytes_{0};
  double build_seconds_ = 0;
  size_t tree_bytes_ = 0;
};

}  // namespace
}  // namespace tessera

extern "C" __attribute__((visibility("default"))) tessera::EmbreeScene* tessera_make_embree_scene(
    const float* positions, size_t vertices, const uint32_t* triangles, size_t count, int threads) {
  return new tessera::Scene(positions, vertices, triangles, count, threads);
}
