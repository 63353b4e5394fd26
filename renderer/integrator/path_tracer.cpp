#include "renderer/integrator/path_tracer.h"

#include "renderer/integrator/batch_tracer.h"
#include "renderer/integrator/path_batches.h"

namespace tessera {

namespace {

class PathTracer final : public Integrator {
 public:
  explicit PathTracer(std::shared_ptr<const Scene> scene)
      : scene_(std::move(scene)), batches_(make_path_batches(*scene_)) {}

  Color background(const Ray& ray) const override {
    return scene_->background.radiance(ray.origin, ray.direction, scene_->lights);
  }
  Color radiance(const Ray& ray, const SampleKey& key, TraceState& state) const override {
    Color found;
    batches_->radiances({&ray, 1}, {&key, 1}, {&found, 1}, state);
    return found;
  }
  const BatchTracer* batches() const override { return batches_.get(); }

 private:
  std::shared_ptr<const Scene> scene_;
  std::unique_ptr<const BatchTracer> batches_;
};

}  // namespace

std::unique_ptr<const Integrator> make_path_tracer(std::shared_ptr<const Scene> scene) {
  return std::make_unique<PathTracer>(std::move(scene));
}

}  // namespace tessera
