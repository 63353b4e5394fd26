#include "query/ray_queries.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <unordered_map>

#include "base/error.h"
#include "query/each_ray.h"
#include "query/geometry_only.h"
#include "renderer/accel/mesh_shape.h"
#include "renderer/scene/read_camera.h"
#include "renderer/shapes/mesh_boundary.h"
#include "renderer/shapes/solid.h"

namespace tessera {

/// Which instances have an inside, found out when it is first asked for.
struct RayQueries::Insides {
  struct Inside {
    bool is_closed = false;
    std::shared_ptr<const MeshBoundary> boundary;  ///< of an open mesh
    /// A ray may leave it without a hit: a solid without an end, or a mesh by a hole.
    bool may_be_left_unseen = false;
  };
  std::once_flag once;
  std::vector<Inside> of;             ///< by instance
  std::vector<uint32_t> left_unseen;  ///< those that may be
  std::vector<uint32_t> open;         ///< meshes, and solids with parts left out
};

namespace {

const MeshShape* mesh_of(const Instance& instance) {
  return dynamic_cast<const MeshShape*>(instance.shape.get());
}

/// All trees are built at once by all threads, and all that hits have is kept.
constexpr BuildScope kScopeOfQueries{.all_meshes = true, .all_attributes = true};

/// Whether rays go so much the same way that a packet of them visits little that each alone would
/// not. Most that do not are told by the first two.
bool go_together(std::span<const Ray> rays, double reach) {
  const Ray& first = rays[0];
  const double length = length_squared(first.direction);
  return std::ranges::all_of(rays.subspan(1), [&](const Ray& ray) {
    const double along = dot(ray.direction, first.direction);
    return along > 0 && along * along > 0.9 * length * length_squared(ray.direction) &&
           length_squared(ray.origin - first.origin) <= reach * reach;
  });
}

bool is_bounded(const Bounds3& b) { return is_finite(b.diagonal()); }

/// Calls visit(hits) for the hits of each instance, of hits sorted by instance.
template <typename Visit>
void for_each_instance(std::span<const Hit> hits, const Visit& visit) {
  for (size_t begin = 0, end = 0; begin < hits.size(); begin = end) {
    while (end < hits.size() && hits[end].instance == hits[begin].instance) ++end;
    visit(hits.subspan(begin, end - begin));
  }
}

/// Those of one instance among hits sorted by instance.
std::span<const Hit> hits_of(std::span<const Hit> hits, uint32_t instance) {
  const auto first =
      std::lower_bound(hits.begin(), hits.end(), instance,
                       [](const Hit& hit, uint32_t number) { return hit.instance < number; });
  const auto last =
      std::upper_bound(first, hits.end(), instance,
                       [](uint32_t number, const Hit& hit) { return number < hit.instance; });
  return {first, last};
}

void sort_by_instance(std::vector<Hit>& hits) {
  std::stable_sort(hits.begin(), hits.end(),
                   [](const Hit& a, const Hit& b) { return a.instance < b.instance; });
}

}  // namespace

RayQueries::RayQueries(const v1::Scene& description, const BlobStore& blobs,
                       const v1::FrameSettings& frame, int threads)
    : description_(geometry_only(description)),
      blobs_(blobs),
      frame_(geometry_only(frame)),
      threads_(threads),
      scene_(build_scene(description_, blobs_, frame_, threads, {}, kScopeOfQueries, &names_)),
      insides_(std::make_unique<Insides>()) {
  for (const std::string& warning : build_warnings(scene_->counters)) spdlog::warn(warning);
  const std::vector<Instance>& instances = scene_->instances;
  if (instances.size() == 1 && instances[0].world_from_object.is_identity() &&
      !instances[0].flip_normals)
    if (const MeshShape* mesh = mesh_of(instances[0])) only_mesh_ = &mesh->accelerator();
  if (const Bounds3 all = bounds(); !all.empty()) reach_ = length(all.diagonal()) / 64;
  std::unordered_map<std::string, uint32_t> known;
  for (const std::string& name : names_.materials) {
    const auto [at, is_new] = known.try_emplace(name, static_cast<uint32_t>(materials_.size()));
    if (is_new) materials_.push_back(name);
    material_of_slot_.push_back(at->second);
  }
  for (size_t i = 0; i < instances.size(); ++i) {
    const MeshShape* mesh = mesh_of(instances[i]);
    if (!mesh || mesh->mesh().original_numbers.empty()) continue;
    rows_.resize(instances.size());
    rows_[i] = &mesh->mesh().original_numbers;
  }
}

RayQueries::~RayQueries() = default;

uint32_t RayQueries::row_of(const Hit& hit) const {
  if (rows_.empty() || !rows_[hit.instance]) return hit.primitive;
  return (*rows_[hit.instance])[hit.primitive];
}

bool RayQueries::closest_hits(const RayArrays& rays, const HitArrays& out,
                              const QueryControl& control) const {
  const Accelerator* const surfaces = only_mesh_ ? only_mesh_ : scene_->surfaces.get();
  return for_each_chunk(rays.count, control, [&](size_t begin, size_t end) {
    constexpr size_t kTogether = 32;
    Ray some[kTogether];
    Hit hits[kTogether];
    int exponents[kTogether];
    TraversalCounters counters;
    for (; begin < end; begin += kTogether) {
      const size_t count = std::min(kTogether, end - begin);
      bool has_extremes = false;
      for (size_t k = 0; k < count; ++k) {
        some[k] = checked_ray(rays, begin + k);
        has_extremes |= is_extreme(some[k].direction);
        hits[k] = {};
        rays.origins.prefetch(begin + kTogether + k);
        rays.directions.prefetch(begin + kTogether + k);
      }
      if (has_extremes) [[unlikely]]
        for (size_t k = 0; k < count; ++k) exponents[k] = scale_if_extreme(some[k]);
      if (surfaces && go_together({some, count}, reach_))
        surfaces->closest_hits({some, count}, {hits, count}, counters);
      else if (surfaces)
        for (size_t k = 0; k < count; ++k) surfaces->closest_hit(some[k], hits[k], counters);
      for (size_t k = 0; k < count; ++k) {
        const Hit& hit = hits[k];
        const bool is_hit = std::isfinite(hit.t);
        const size_t i = begin + k;
        if (out.t) out.t[i] = has_extremes ? std::ldexp(hit.t, -exponents[k]) : hit.t;
        if (out.instance) out.instance[i] = is_hit ? hit.instance : kNoInstance;
        if (out.primitive) out.primitive[i] = is_hit ? row_of(hit) : kNoInstance;
        if (out.uv) out.uv[2 * i] = hit.u, out.uv[2 * i + 1] = hit.v;
      }
    }
  });
}

bool RayQueries::occluded(const RayArrays& rays, uint8_t* result,
                          const QueryControl& control) const {
  const Accelerator* const surfaces = only_mesh_ ? only_mesh_ : scene_->surfaces.get();
  return for_each_chunk(rays.count, control, [&](size_t begin, size_t end) {
    TraversalCounters counters;
    for (size_t i = begin; i < end; ++i) {
      Ray ray = checked_ray(rays, i);
      scale_if_extreme(ray);
      result[i] = surfaces && surfaces->any_hit(ray, counters) ? 1 : 0;
    }
  });
}

/// In the order of (t, instance, primitive), each once.
void RayQueries::find_all(const Ray& ray, std::vector<Hit>& hits) const {
  hits.clear();
  if (!scene_->surfaces || !can_hit(ray)) return;
  TraversalCounters counters;
  scene_->surfaces->all_hits(ray, hits, counters);
  const auto order = [](const Hit& h) { return std::tuple(h.t, h.instance, h.primitive); };
  std::sort(hits.begin(), hits.end(),
            [&](const Hit& a, const Hit& b) { return order(a) < order(b); });
  hits.erase(std::unique(hits.begin(), hits.end(),
                         [&](const Hit& a, const Hit& b) { return order(a) == order(b); }),
             hits.end());
}

std::optional<AllHits> RayQueries::all_hits(const RayArrays& rays,
                                            const QueryControl& control) const {
  AllHits all;
  all.offsets.resize(rays.count + 1);
  std::vector<std::vector<Hit>> chunks((rays.count + kRaysOfChunk - 1) / kRaysOfChunk);
  const bool done = for_each_chunk(rays.count, control, [&](size_t begin, size_t end) {
    std::vector<Hit>& chunk = chunks[begin / kRaysOfChunk];
    std::vector<Hit> hits;
    for (size_t i = begin; i < end; ++i) {
      Ray ray = checked_ray(rays, i);
      const int exponent = scale_if_extreme(ray);
      find_all(ray, hits);
      if (exponent != 0)
        for (Hit& hit : hits) hit.t = std::ldexp(hit.t, -exponent);
      chunk.insert(chunk.end(), hits.begin(), hits.end());
      all.offsets[i + 1] = static_cast<int64_t>(hits.size());
    }
  });
  if (!done) return std::nullopt;
  for (size_t i = 0; i < rays.count; ++i) all.offsets[i + 1] += all.offsets[i];
  const auto total = static_cast<size_t>(all.offsets.back());
  all.t.reserve(total), all.instance.reserve(total), all.primitive.reserve(total);
  all.uv.reserve(2 * total);
  for (std::vector<Hit>& chunk : chunks) {
    if (control.cancelled && *control.cancelled) return std::nullopt;
    for (const Hit& hit : chunk) {
      all.t.push_back(hit.t);
      all.instance.push_back(hit.instance);
      all.primitive.push_back(row_of(hit));
      all.uv.push_back(hit.u), all.uv.push_back(hit.v);
    }
    chunk = {};
  }
  return all;
}

bool RayQueries::crossings(const RayArrays& rays, int32_t* result,
                           const QueryControl& control) const {
  return for_each_chunk(rays.count, control, [&](size_t begin, size_t end) {
    std::vector<Hit> hits;
    for (size_t i = begin; i < end; ++i) {
      Ray ray = checked_ray(rays, i);
      scale_if_extreme(ray);
      ray.cull = Cull::none;
      find_all(ray, hits);
      sort_by_instance(hits);
      result[i] = 0;
      for_each_instance(hits, [&](std::span<const Hit> of) {
        result[i] += crossing_number_of(scene_->instances[of[0].instance], ray, of);
      });
    }
  });
}

const RayQueries::Insides& RayQueries::insides() const {
  std::call_once(insides_->once, [this] {
    std::unordered_map<const Shape*, Insides::Inside> known;
    for (uint32_t i = 0; i < scene_->instances.size(); ++i) {
      const Shape& shape = *scene_->instances[i].shape;
      const MeshShape* const mesh = mesh_of(scene_->instances[i]);
      const auto [found, is_new] = known.try_emplace(&shape);
      Insides::Inside& inside = found->second;
      if (is_new) inside.is_closed = is_closed(shape);
      if (is_new && mesh && !inside.is_closed)
        inside.boundary = std::make_shared<const MeshBoundary>(mesh->mesh());
      if (is_new)
        inside.may_be_left_unseen =
            inside.boundary || (inside.is_closed && !is_bounded(shape.bounds()));
      insides_->of.push_back(inside);
      if (inside.may_be_left_unseen) insides_->left_unseen.push_back(i);
      const bool is_solid = dynamic_cast<const Solid*>(&shape) != nullptr;
      if (inside.boundary || (is_solid && !inside.is_closed)) insides_->open.push_back(i);
    }
  });
  return *insides_;
}

std::vector<RayQueries::OpenShape> RayQueries::open_shapes() const {
  std::vector<OpenShape> open;
  for (const uint32_t i : insides().open) {
    OpenShape& shape = open.emplace_back(OpenShape{.instance = i});
    const MeshBoundary* const boundary = insides().of[i].boundary.get();
    if (!boundary) continue;
    const std::vector<OpenEdge>& edges = boundary->edges();
    shape.is_mesh = true;
    shape.edges = edges.size();
    if (!edges.empty()) shape.from = edges[0].from, shape.to = edges[0].to;
  }
  return open;
}

bool RayQueries::contains(size_t count, const VectorRows& points,
                          const std::optional<std::vector<uint32_t>>& among, OpenInside open,
                          uint8_t* result, const QueryControl& control) const {
  const std::vector<Instance>& instances = scene_->instances;
  const Insides& insides = this->insides();
  std::vector<bool> is_asked(instances.size());  // of those that have an inside
  for (uint32_t i = 0; i < instances.size(); ++i) {
    const Insides::Inside& inside = insides.of[i];
    is_asked[i] = inside.is_closed || (open == OpenInside::by_winding && inside.boundary);
  }
  if (among) {
    std::vector<bool> chosen(instances.size());
    for (const uint32_t number : *among) {
      if (number >= instances.size())
        throw usage_error(
            fmt::format("shape: instance {}; expected one below {}", number, instances.size()));
      if (!is_asked[number])
        throw usage_error(fmt::format(
            "shape: instance {}, which is open; expected a solid or a closed mesh", number));
      chosen[number] = true;
    }
    is_asked = std::move(chosen);
  }
  return for_each_chunk(count, control, [&](size_t begin, size_t end) {
    std::vector<Hit> hits;
    for (size_t i = begin; i < end; ++i) {
      // Along an axis vertices are projected without rounding. Which axis makes no difference.
      const Ray ray{Point3{} + points[i], {0, 0, 1}};
      bool inside = false;
      if (can_hit(ray)) {
        find_all(ray, hits);
        sort_by_instance(hits);
        for_each_instance(hits, [&](std::span<const Hit> of) {
          const uint32_t number = of[0].instance;
          if (inside || !is_asked[number] || insides.of[number].may_be_left_unseen) return;
          inside = holds_start_of(instances[number], ray, of);
        });
        for (const uint32_t number : insides.left_unseen) {
          if (inside || !is_asked[number]) continue;
          const std::span<const Hit> of = hits_of(hits, number);
          const MeshBoundary* const boundary = insides.of[number].boundary.get();
          inside = boundary ? goes_around_start_of(instances[number], *boundary, ray, of)
                            : holds_start_of(instances[number], ray, of);
        }
      }
      result[i] = inside ? 1 : 0;
    }
  });
}

Camera RayQueries::camera(const std::string& name, int width, int height) const {
  const bool same = (name.empty() || name == frame_.camera()) &&
                    (width == 0 || width == this->width()) &&
                    (height == 0 || height == this->height());
  if (same) return *scene_->camera;
  v1::FrameSettings frame = frame_;
  if (!name.empty()) frame.set_camera(name);
  if (width == 0) width = this->width();
  if (height == 0) height = this->height();
  const CameraChoice choice = read_camera(description_, frame.camera(), scene_->settings.time);
  if (!choice.frame_all) return {choice.settings, width, height};
  // It is placed so that it sees all of the scene; no tree is built for that.
  frame.set_width(static_cast<uint32_t>(width));
  frame.set_height(static_cast<uint32_t>(height));
  frame.set_accelerator("linear");
  return *build_scene(description_, blobs_, frame, threads_)->camera;
}

Bounds3 RayQueries::bounds() const {
  Bounds3 all;
  for (const Instance& instance : scene_->instances)
    if (const Bounds3 b = bounds_of(instance); is_bounded(b)) all.extend(b);
  return all;
}

AcceleratorStatistics RayQueries::statistics() const {
  AcceleratorStatistics sum =
      scene_->surfaces ? scene_->surfaces->statistics() : AcceleratorStatistics{};
  std::vector<const Shape*> counted;
  for (const Instance& instance : scene_->instances)
    if (mesh_of(instance)) counted.push_back(instance.shape.get());
  std::sort(counted.begin(), counted.end());
  counted.erase(std::unique(counted.begin(), counted.end()), counted.end());
  for (const Shape* shape : counted) {
    const AcceleratorStatistics of =
        static_cast<const MeshShape*>(shape)->accelerator().statistics();
    sum.primitives += of.primitives, sum.nodes += of.nodes, sum.leaves += of.leaves;
    sum.references += of.references, sum.bytes += of.bytes;
    sum.depth = std::max(sum.depth, of.depth);
    sum.build_seconds += of.build_seconds;
  }
  return sum;
}

}  // namespace tessera
