// In the module, with embree_scene_main.cpp.
#include <embree3/rtcore.h>

#include <atomic>
#include <limits>
#include <string>

#include "renderer/accel/embree/counting_device.h"
#include "renderer/accel/embree/embree_module.h"

namespace tessera {
namespace {

struct Context {
  RTCIntersectContext embree;
  EmbreeBoxes::Test test;
  void* context;
};

void bounds_of_box(const RTCBoundsFunctionArguments* arguments) {
  const auto* boxes = static_cast<const std::array<float, 6>*>(arguments->geometryUserPtr);
  const std::array<float, 6>& b = boxes[arguments->primID];
  RTCBounds& out = *arguments->bounds_o;
  out.lower_x = b[0], out.lower_y = b[1], out.lower_z = b[2];
  out.upper_x = b[3], out.upper_y = b[4], out.upper_z = b[5];
}

void test_box(const RTCIntersectFunctionNArguments* arguments) {
  if (arguments->valid[0] == 0) return;
  auto* context = reinterpret_cast<Context*>(arguments->context);
  RTCRay& ray = reinterpret_cast<RTCRayHit*>(arguments->rayhit)->ray;
  ray.tfar = context->test(context->context, arguments->primID, ray.tfar);
}

void test_any_in_box(const RTCOccludedFunctionNArguments* arguments) {
  if (arguments->valid[0] == 0) return;
  auto* context = reinterpret_cast<Context*>(arguments->context);
  RTCRay& ray = *reinterpret_cast<RTCRay*>(arguments->ray);
  ray.tfar = context->test(context->context, arguments->primID, ray.tfar);
}

RTCRay to_embree(const EmbreeBoxRay& ray) {
  RTCRay r;
  r.org_x = ray.origin[0], r.org_y = ray.origin[1], r.org_z = ray.origin[2];
  r.dir_x = ray.direction[0], r.dir_y = ray.direction[1], r.dir_z = ray.direction[2];
  r.tnear = ray.t_min, r.tfar = ray.t_max, r.time = 0, r.mask = 0xffffffffu, r.id = 0, r.flags = 0;
  return r;
}

class Boxes final : public EmbreeBoxes {
 public:
  Boxes(const std::array<float, 6>* boxes, size_t count, int threads) {
    device_ = new_counting_device(threads, bytes_);
    scene_ = rtcNewScene(device_);
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(count));
    rtcSetGeometryUserData(geometry, const_cast<std::array<float, 6>*>(boxes));
    rtcSetGeometryBoundsFunction(
        geometry, [](const RTCBoundsFunctionArguments* a) { bounds_of_box(a); }, nullptr);
    rtcSetGeometryIntersectFunction(geometry, test_box);
    rtcSetGeometryOccludedFunction(geometry, test_any_in_box);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
  }
  ~Boxes() override {
    rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  void visit(const EmbreeBoxRay& ray, Test test, void* context) const override {
    Context with = make_context(test, context);
    RTCRayHit r;
    r.ray = to_embree(ray);
    r.hit.geomID = r.hit.primID = r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene_, &with.embree, &r);
  }
  void visit_any(const EmbreeBoxRay& ray, Test test, void* context) const override {
    Context with = make_context(test, context);
    RTCRay r = to_embree(ray);
    rtcOccluded1(scene_, &with.embree, &r);
  }
  size_t bytes() const override { return static_cast<size_t>(bytes_.load()); }

 private:
  static Context make_context(Test test, void* context) {
    Context with;
    rtcInitIntersectContext(&with.embree);
    with.test = test;
    with.context = context;
    return with;
  }

  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
  std::atomic<ssize_t> bytes_{0};
};

}  // namespace
}  // namespace tessera

extern "C" __attribute__((visibility("default"))) tessera::EmbreeBoxes* tessera_make_embree_boxes(
    const std::array<float, 6>* boxes, size_t count, int threads) {
  return new tessera::Boxes(boxes, count, threads);
}
