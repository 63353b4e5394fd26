#include "bench/rays.h"
#include "bench/error/statistics.h"
#include "bench/thread_seconds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <random>

#include "renderer/accel/embree/embree_module.h"
#include "renderer/accel/linear_scan.h"
#include "renderer/accel/make_accelerator.h"
#include "renderer/math/elementary.h"
#include "renderer/shapes/surface_interaction.h"

namespace tessera {
namespace {

struct RaySet {
  std::string kind;
  bool any = false;
  std::vector<Ray> rays;
  bool together = false;  ///< neighbours go much the same way: traced as packets
};

struct Answer {
  double t = 0;
  uint32_t primitive = EmbreeScene::kNothing;
};

BenchView view_outside(const Bounds3& box) {
  const double size = length(box.diagonal());
  return {box.center() + Vec3{0.35, 0.3, 0.9} * (size * 0.85), box.center(),
          box.center() + Vec3{0.6, 0.9, 0.7} * size};
}

class RayMaker {
 public:
  RayMaker(const MeshShape& shape, const std::optional<BenchView>& view, uint64_t seed)
      : shape_(shape), view_(view ? *view : view_outside(shape.bounds())), random_(seed) {}

  std::vector<RaySet> make(int side) {
    RaySet primary{"primary", false, primary_rays(side)};
    const std::vector<SurfaceInteraction> first = hits(primary.rays);
    RaySet shadow{"shadow", true, {}}, diffuse{"diffuse", false, {}}, ao{"ao", true, {}};
    const double size = length(shape_.bounds().diagonal());
    for (const SurfaceInteraction& s : first) {
      shadow.rays.push_back(spawn(s, view_.light - s.point));
      shadow.rays.back().t_max = 1;
      diffuse.rays.push_back(spawn(s, hemisphere(s)));
      ao.rays.push_back(spawn(s, hemisphere(s)));
      ao.rays.back().t_max = 0.25 * size;
    }
    RaySet shuffled{"shuffled", false, {}};
    for (const SurfaceInteraction& s : hits(diffuse.rays))
      shuffled.rays.push_back(spawn(s, hemisphere(s)));
    std::shuffle(shuffled.rays.begin(), shuffled.rays.end(), random_);
    RaySet packets{"packets", false, primary.rays, true};
    return {std::move(primary), std::move(packets), std::move(shadow),
            std::move(diffuse), std::move(ao),      std::move(shuffled)};
  }

 private:
  std::vector<Ray> primary_rays(int side) {
    const Affine camera = look_at(view_.eye, view_.target, {0, 1, 0});
    std::vector<Ray> rays;
    // In tiles of 4 x 4, as a renderer would.
    for (int tile = 0; tile < side / 4 * (side / 4); ++tile) {
      for (int i = 0; i < 16; ++i) {
        const int x = tile % (side / 4) * 4 + i % 4, y = tile / (side / 4) * 4 + i / 4;
        const Vec3 d{(x + 0.5) / side - 0.5, 0.5 - (y + 0.5) / side, -0.85};
        rays.push_back(to_single({camera(Point3{}), normalize(camera(d))}));
      }
    }
    return rays;
  }

  /// Both contestants get the same ray, and Embree one that does not start below the surface.
  static Ray to_single(Ray ray) {
    for (int a = 0; a < 3; ++a) {
      ray.origin[a] = static_cast<float>(ray.origin[a]);
      ray.direction[a] = static_cast<float>(ray.direction[a]);
    }
    return ray;
  }
  Ray spawn(const SurfaceInteraction& s, const Vec3& direction) const {
    const double reach = 1e-5 * length(shape_.bounds().diagonal());
    return to_single({s.point + static_cast<Vec3>(s.geometric_normal) * reach, direction});
  }

  std::vector<SurfaceInteraction> hits(const std::vector<Ray>& rays) {
    std::vector<SurfaceInteraction> found;
    for (const Ray& ray : rays) {
      Hit hit;
      TraversalCounters counters;
      if (!shape_.closest_hit(ray, hit, counters)) continue;
      SurfaceInteraction s = to_world(shape_.surface(ray, hit), Transform{}, false, 0);
      if (dot(s.geometric_normal, ray.direction) > 0) s.geometric_normal = -s.geometric_normal;
      found.push_back(s);
    }
    return found;
  }

  /// Cosine-weighted about the geometric normal.
  Vec3 hemisphere(const SurfaceInteraction& s) {
    std::uniform_real_distribution<> unit;
    const double z = 1 - 2 * unit(random_), turn = 2 * portable::kPi * unit(random_);
    const double ring = std::sqrt(std::max(0.0, 1 - z * z));
    const Vec3 ball{ring * portable::cos(turn), ring * portable::sin(turn), z};
    const Vec3 d = static_cast<Vec3>(s.geometric_normal) + ball * 0.999;
    return normalize(d);
  }

  const MeshShape& shape_;
  BenchView view_;
  std::mt19937_64 random_;
};

/// One thing that traces a ray set, with its answers.
struct Contestant {
  std::string name;
  std::function<void(const RaySet&, size_t begin, size_t end)> trace;
  std::vector<Answer> answers;
  TraversalCounters counters;
  double build_seconds = 0, bytes_per_triangle = 0;
};

void trace_stretch(const Accelerator& accelerator, const RaySet& set, size_t begin, size_t end,
                   std::vector<Answer>& answers, TraversalCounters& counters) {
  answers.resize(set.rays.size());
  if (set.together) {
    std::vector<Hit> hits(end - begin);
    accelerator.closest_hits({set.rays.data() + begin, end - begin}, hits, counters);
    for (size_t i = begin; i < end; ++i) {
      const Hit& hit = hits[i - begin];
      answers[i] = {hit.t, std::isfinite(hit.t) ? hit.primitive : EmbreeScene::kNothing};
    }
    return;
  }
  for (size_t i = begin; i < end; ++i) {
    if (set.any) {
      const bool hit = accelerator.any_hit(set.rays[i], counters);
      answers[i] = {0, hit ? 0 : EmbreeScene::kNothing};
    } else {
      Hit hit;
      const bool found = accelerator.closest_hit(set.rays[i], hit, counters);
      answers[i] = {hit.t, found ? hit.primitive : EmbreeScene::kNothing};
    }
  }
}

std::vector<EmbreeRay> to_float(const RaySet& set) {
  std::vector<EmbreeRay> rays;
  for (const Ray& r : set.rays) {
    EmbreeRay f{};
    for (int a = 0; a < 3; ++a) {
      f.origin[a] = static_cast<float>(r.origin[a]);
      f.direction[a] = static_cast<float>(r.direction[a]);
    }
    f.t_max = static_cast<float>(r.t_max);
    rays.push_back(f);
  }
  return rays;
}

/// Answers of a linear scan to every `step`-th ray of a set.
struct Oracle {
  size_t step = 1;
  std::vector<Answer> answers;

  Oracle(const RaySet& set, const std::shared_ptr<const TriangleMesh>& mesh, size_t tests) {
    const size_t affordable = std::max<size_t>(1, tests / mesh->triangles.size());
    step = (set.rays.size() + affordable - 1) / affordable;
    const MeshLinearScan scan(mesh);
    TraversalCounters counters;
    for (size_t i = 0; i < set.rays.size(); i += step) {
      Hit hit;
      const bool found = set.any ? scan.any_hit(set.rays[i], counters)
                                 : scan.closest_hit(set.rays[i], hit, counters);
      answers.push_back({set.any ? 0 : hit.t, !found    ? EmbreeScene::kNothing
                                              : set.any ? 0
                                                        : hit.primitive});
    }
  }
  size_t mismatches(const std::vector<Answer>& of) const {
    size_t count = 0;
    for (size_t i = 0; i < answers.size(); ++i)
      if (of[i * step].t != answers[i].t || of[i * step].primitive != answers[i].primitive) ++count;
    return count;
  }
};

/// Rays whose answers differ by more than single precision explains.
size_t differing(const RaySet& set, const std::vector<Answer>& a, const std::vector<EmbreeRay>& b,
                 double size) {
  size_t count = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    const bool hit_a = a[i].primitive != EmbreeScene::kNothing;
    const bool hit_b = b[i].primitive != EmbreeScene::kNothing;
    if (hit_a != hit_b) {
      ++count;
    } else if (!set.any && hit_a && a[i].primitive != b[i].primitive) {
      const double t = b[i].t;
      if (std::abs(a[i].t - t) > 1e-5 * (std::abs(t) + size)) ++count;
    }
  }
  return count;
}

template <typename Work>
double seconds_of(Work&& work) {
  const double start = thread_seconds();
  work();
  return thread_seconds() - start;
}

void bench_set(const BenchMesh& scene, const RaySet& set, const Oracle& oracle,
               std::vector<Contestant>& contestants, const EmbreeScene* embree,
               double embree_build_seconds, const RayBenchOptions& options,
               std::vector<RayBenchRow>& rows) {
  std::vector<EmbreeRay> floats = to_float(set);
  // Short stretches in turn, so that whatever else the machine does falls on all alike.
  constexpr size_t kStretch = 4096;
  std::vector<std::vector<double>> seconds(contestants.size() + 1);
  for (Contestant& contestant : contestants) contestant.counters = {};
  for (int round = 0; round < options.rounds + 1; ++round) {
    std::vector<double> taken(contestants.size() + 1, 0);
    for (size_t begin = 0; begin < floats.size(); begin += kStretch) {
      const size_t end = std::min(floats.size(), begin + kStretch);
      for (size_t c = 0; c < contestants.size(); ++c)
        taken[c] += seconds_of([&] { contestants[c].trace(set, begin, end); });
      if (!embree) continue;
      const std::span<EmbreeRay> stretch{floats.data() + begin, end - begin};
      taken.back() += seconds_of([&] {
        if (set.any)
          embree->any_hits(stretch);
        else if (set.together)
          embree->closest_hits_by_eights(stretch);
        else
          embree->closest_hits(stretch);
      });
    }
    if (round == 0) continue;  // warms up
    for (size_t c = 0; c < taken.size(); ++c) seconds[c].push_back(taken[c]);
  }
  const double mrays = static_cast<double>(set.rays.size()) * 1e-6;
  const double size = length(scene.mesh.bounds().diagonal());
  for (size_t c = 0; c < contestants.size(); ++c) {
    RayBenchRow row{scene.name, contestants[c].name, set.kind};
    row.mrays_per_second = mrays / median(seconds[c]);
    row.build_seconds = contestants[c].build_seconds;
    row.bytes_per_triangle = contestants[c].bytes_per_triangle;
    row.mismatches = oracle.mismatches(contestants[c].answers);
    row.rays_checked = oracle.answers.size();
    const double traced = static_cast<double>(set.rays.size()) * (options.rounds + 1);
    row.node_visits_per_ray = static_cast<double>(contestants[c].counters.node_visits) / traced;
    row.primitive_tests_per_ray =
        static_cast<double>(contestants[c].counters.primitive_tests) / traced;
    if (embree) {
      std::vector<double> ratios;
      for (size_t round = 0; round < seconds[c].size(); ++round)
        ratios.push_back(seconds.back()[round] / seconds[c][round]);
      row.ratio_to_embree = median(std::move(ratios));
      row.unlike_embree = differing(set, contestants[c].answers, floats, size);
    }
    rows.push_back(row);
  }
  if (!embree) return;
  const auto triangles = static_cast<double>(scene.mesh.triangles.size());
  RayBenchRow& row = rows.emplace_back(RayBenchRow{scene.name, "embree-default", set.kind});
  row.mrays_per_second = mrays / median(seconds.back());
  row.ratio_to_embree = 1;
  row.build_seconds = embree_build_seconds;
  row.bytes_per_triangle = static_cast<double>(embree->bytes()) / triangles;
}

}  // namespace

BenchView view_inside(const Bounds3& box) {
  return {box.center() + box.diagonal() * 0.4, box.center(),
          box.center() + Vec3{0, 0.4 * box.diagonal().y, 0}};
}

std::vector<RayBenchRow> bench_rays(const std::vector<BenchMesh>& meshes,
                                    const RayBenchOptions& options) {
  std::vector<RayBenchRow> rows;
  for (const BenchMesh& scene : meshes) {
    const auto mesh = std::make_shared<const TriangleMesh>(scene.mesh);
    const auto make_embree = [&] {
      return make_embree_scene({&mesh->positions.data()->x, mesh->positions.size() * 3},
                               {mesh->triangles.data()->data(), mesh->triangles.size() * 3},
                               options.build_threads);
    };
    const auto embree = make_embree();
    double embree_build_seconds = embree ? embree->build_seconds() : 0;
    std::vector<std::unique_ptr<const Accelerator>> built;
    std::vector<Contestant> contestants;
    contestants.reserve(options.accelerators.size());
    for (const AcceleratorKind kind : options.accelerators) {
      built.push_back(make_mesh_accelerator(mesh, kind, options.build_threads));
      const AcceleratorStatistics statistics = built.back()->statistics();
      Contestant& added = contestants.emplace_back();
      added.name = std::string(accelerator_name(kind));
      added.build_seconds = statistics.build_seconds;
      added.bytes_per_triangle =
          static_cast<double>(statistics.bytes) / static_cast<double>(mesh->triangles.size());
      added.trace = [&added, &accelerator = *built.back()](const RaySet& set, size_t begin,
                                                           size_t end) {
        trace_stretch(accelerator, set, begin, end, added.answers, added.counters);
      };
    }
    // By turns again, for whatever else the machine does; the shortest time counts.
    for (int round = 1; round < std::min(options.rounds, 5); ++round) {
      for (size_t c = 0; c < contestants.size(); ++c) {
        const auto again =
            make_mesh_accelerator(mesh, options.accelerators[c], options.build_threads);
        contestants[c].build_seconds =
            std::min(contestants[c].build_seconds, again->statistics().build_seconds);
      }
      if (embree)
        embree_build_seconds = std::min(embree_build_seconds, make_embree()->build_seconds());
    }
    const auto shape =
        make_mesh_shape(mesh, AcceleratorKind::bvh, std::max(1, options.build_threads));
    for (const RaySet& set : RayMaker(*shape, scene.view, options.seed).make(options.image_side)) {
      if (set.rays.empty()) continue;
      const Oracle oracle(set, mesh, options.oracle_tests);
      bench_set(scene, set, oracle, contestants, embree.get(), embree_build_seconds, options, rows);
    }
  }
  return rows;
}

std::vector<RayBenchRow> geometric_means(const std::vector<RayBenchRow>& rows) {
  std::vector<RayBenchRow> means;
  std::vector<double> counts;
  static constexpr double RayBenchRow::*kAveraged[] = {
      &RayBenchRow::mrays_per_second, &RayBenchRow::ratio_to_embree, &RayBenchRow::build_seconds,
      &RayBenchRow::bytes_per_triangle};
  for (const RayBenchRow& row : rows) {
    size_t at = 0;
    while (at < means.size() &&
           (means[at].accelerator != row.accelerator || means[at].kind != row.kind))
      ++at;
    if (at == means.size()) {
      means.push_back({"geometric mean", row.accelerator, row.kind});
      counts.push_back(0);
    }
    ++counts[at];
    for (const auto member : kAveraged) means[at].*member += std::log(row.*member);
    means[at].mismatches += row.mismatches;
    means[at].rays_checked += row.rays_checked;
    means[at].unlike_embree += row.unlike_embree;
  }
  for (size_t i = 0; i < means.size(); ++i)
    for (const auto member : kAveraged) means[i].*member = std::exp(means[i].*member / counts[i]);
  return means;
}

}  // namespace tessera
