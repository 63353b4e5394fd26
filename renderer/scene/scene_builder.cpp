#include "renderer/scene/scene_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/cancellation.h"
#include "base/error.h"
#include "base/parallel.h"
#include "base/plural.h"
#include "renderer/accel/make_accelerator.h"
#include "renderer/scene/csg_plan.h"
#include "renderer/scene/material_table.h"
#include "renderer/scene/outline.h"
#include "renderer/scene/read_camera.h"
#include "renderer/scene/read_shading.h"
#include "renderer/scene/read_shape.h"
#include "renderer/scene/scene_graph.h"
#include "renderer/scene/seen_rect.h"
#include "renderer/shading/media.h"
#include "renderer/shapes/outline_points.h"

namespace tessera {

namespace {

/// One shape's materials, and what follows for every instance of it.
struct ShapeMaterials {
  uint32_t first = 0, count = 0;
  bool is_clear = false;   ///< may let shadow rays through
  bool has_alpha = false;  ///< may let any ray through unbent
  KeptAttributes keep;
  Cull cull = Cull::none;
};

class SceneBuilder {
 public:
  SceneBuilder(const v1::Scene& description, const BlobStore& blobs, const v1::FrameSettings& frame,
               int threads, const Sharing& sharing, const BuildScope& scope, SceneNames* names)
      : description_(description),
        frame_(frame),
        scope_(scope),
        names_(names),
        source_{.blobs = blobs,
                .accelerator = {},
                .threads = threads,
                .keep = {.normals = true,
                         .uvs = true,
                         .second_uvs = true,
                         .tangents = true,
                         .colors = true},
                .sharing = sharing},
        textures_(description, blobs),
        materials_(description, textures_) {}

  std::shared_ptr<const Scene> build() {
    if (description_.includes_size() > 0) {
      throw scene_error("the scene still includes other files; expected them to be read in");
    }
    scene_->settings = read_settings(description_.settings(), frame_);
    const RenderSettings& settings = scene_->settings;
    source_.accelerator = settings.accelerator;
    // Machines differ in what they visit, workers of one picture must not.
    if (settings.view == View::cost) source_.code = &common_kernels();
    CameraChoice choice = read_camera(description_, frame_.camera(), settings.time);
    scene_->sampler.emplace(settings.sampler);
    scene_->background = read_background(description_.background(), textures_);
    scene_->fog = read_fog(description_.fog());
    graph_ = unfold_graph(description_, settings.time, choice.settings.world_from_camera,
                          settings.aovs.has(Aov::origin));
    add_materials(choice);
    build_shapes();
    add_instances();
    if (settings.aovs.has(Aov::origin)) add_origins();
    add_camera(choice);
    add_lights(choice);
    if (settings.integrator == IntegratorKind::path) add_path_lights();
    build_accelerators();
    scene_->features.plain_light = has_plain_light();
    scene_->seen = seen_rect(*scene_);
    count();
    return scene_;
  }

 private:
  /// Whitted's, but where surfaces are all that emits, which light nothing there, and others
  /// would show their light.
  void choose_integrator(const CameraChoice& choice) {
    RenderSettings& settings = scene_->settings;
    if (settings.integrator == IntegratorKind::automatic) {
      const bool has_lights =
          !graph_.lights.empty() || choice.headlight || !is_black(settings.ambient);
      const BackgroundKind background = scene_->background.kind;
      bool emits = background == BackgroundKind::sun_and_sky || scene_->background.picture;
      bool scatters = false;
      for (const Material& material : materials_.materials()) {
        if (!material.is_lit()) continue;
        emits |= !is_black(material.emission);
        scatters |= material.scatters();
      }
      settings.integrator =
          emits && scatters && !has_lights ? IntegratorKind::path : IntegratorKind::whitted;
      scene_->counters[kAutoChosePath] = settings.integrator == IntegratorKind::path ? 1 : 0;
    }
    constexpr uint32_t kPathDepth = 64;
    if (settings.integrator == IntegratorKind::path &&
        !description_.settings().integrator().has_max_depth()) {
      settings.max_depth = kPathDepth;
    }
  }

  void add_camera(CameraChoice& choice) {
    const RenderSettings& settings = scene_->settings;
    if (choice.frame_all) {
      choice.settings =
          framed_view(choice.settings, settings.width, settings.height, bounded_points());
    }
    scene_->camera.emplace(choice.settings, settings.width, settings.height);
    constexpr uint64_t kMostRays = uint64_t{1} << 32;  // each has a number of its own
    const uint64_t rays =
        uint64_t{settings.sampler.samples_per_pixel} * scene_->camera->lens_samples();
    if (rays > kMostRays) {
      fail_value({.kind = "camera"}, "lens.samples", fmt::format("{} rays a pixel", rays),
                 fmt::format("at most {}, samples per pixel times lens samples", kMostRays));
    }
    const Camera::PixelCone cone = scene_->camera->pixel_cone();
    const uint32_t most = settings.sampler.samples_per_pixel;
    scene_->cones = settings.target_error > 0 ? SampleCones(cone, settings.first_look(), most)
                                              : SampleCones(cone, most);
  }

  /// Of all instances that end somewhere: of their outlines, as long as these are few enough, else
  /// of the boxes of their shapes, or of the box around all.
  std::vector<Point3> bounded_points() const {
    constexpr size_t kMostPoints = size_t{1} << 20, kCorners = 8;
    size_t most = 0;
    for (const uint32_t shape : instance_shapes_) most += outline_limit(shapes_[shape]);
    std::vector<std::vector<Point3>> outlines;
    for (size_t i = 0; i < shapes_.size(); ++i)
      outlines.push_back(outline(shapes_[i], most <= kMostPoints));
    const bool by_one_box = kCorners * scene_->instances.size() > kMostPoints;
    Bounds3 all;
    std::vector<Point3> points;
    for (size_t i = 0; i < scene_->instances.size(); ++i) {
      for (const Point3& p : outlines[instance_shapes_[i]]) {
        const Point3 at = scene_->instances[i].world_from_object.point(p);
        if (!is_finite(at - Point3{})) continue;
        if (by_one_box)
          all.extend(at);
        else
          points.push_back(at);
      }
    }
    return by_one_box && !all.empty() ? box_corners(all) : points;
  }

  void add_lights(const CameraChoice& choice) {
    using Settings = v1::IntegratorSettings;
    for (Light& light : graph_.lights) {
      if (scene_->settings.shadows != Settings::SHADOWS_BY_LIGHT) {
        light.casts_shadow = scene_->settings.shadows == Settings::SHADOWS_ON;
      }
      if (light.shadow_intensity == 0) light.casts_shadow = false;
    }
    if (choice.headlight) {
      graph_.global_lights.push_back(static_cast<uint32_t>(graph_.lights.size()));
      graph_.lights.push_back(read_headlight(*choice.headlight, choice.settings.world_from_camera));
    }
    scene_->lights = graph_.lights;
    // A glowing background looks at every light, but a black one lights no surface.
    const auto is_dark = [&](uint32_t i) {
      return is_black(scene_->lights[i].intensity) && is_black(scene_->lights[i].ambient);
    };
    std::vector<uint32_t> globals = std::move(graph_.global_lights);
    scene_->scoped_lights = std::move(graph_.scopes);
    scene_->counters["lights_dark"] = std::erase_if(globals, is_dark);
    std::sort(globals.begin(), globals.end());
    scene_->global_lights = LightGrid(scene_->lights, std::move(globals));
    for (std::vector<uint32_t>& scope : scene_->scoped_lights) {
      std::erase_if(scope, is_dark);
      std::sort(scope.begin(), scope.end());
    }
  }

  void add_materials(const CameraChoice& choice) {
    for (const GraphShape& graph_shape : graph_.shapes) {
      const Where where{.kind = graph_shape.path.c_str()};
      ShapeMaterials entry;
      entry.first = static_cast<uint32_t>(scene_->material_slots.size());
      csg_plans_.emplace_back();
      if (graph_shape.shape->has_csg()) {
        CsgPlan& plan = csg_plans_.back();
        plan = plan_csg(where, *graph_shape.shape, description_, scene_->settings.time,
                        scene_->settings.aovs.has(Aov::origin) ? &graph_.ways : nullptr);
        for (const CsgPlan::Step& step : plan.steps) {
          if (step.solid) use_materials({.kind = step.path.c_str()}, *step.solid, step.material);
        }
      } else {
        use_materials(where, *graph_shape.shape);
      }
      entry.count = static_cast<uint32_t>(scene_->material_slots.size()) - entry.first;
      shape_materials_.push_back(entry);
    }
    choose_integrator(choice);
    for (ShapeMaterials& entry : shape_materials_) classify(entry);
    scene_->features.lambert = true;
    for (const Material& material : materials_.materials()) {
      scene_->features.rich |= material.is_rich();
      scene_->features.lambert &= material.is_lambert();
    }
    scene_->materials = materials_.take();
    scene_->inputs = materials_.take_inputs();
    texture_count_ = textures_.size();
    scene_->textures = textures_.take();
  }

  void use_materials(const Where& where, const v1::Shape& shape,
                     const std::string& otherwise = {}) {
    for (const std::string& name : shape.materials()) {
      use_material(where, name);
    }
    if (shape.materials().empty()) use_material(where, otherwise);
  }
  void use_material(const Where& where, const std::string& name) {
    scene_->material_slots.push_back(materials_.use(where, name));
    if (names_) names_->materials.push_back(name);
  }

  bool shows_normals(const Material& material) const {
    switch (scene_->settings.view) {
      case View::normals:
        return true;
      case View::depth:
      case View::albedo:
      case View::ids:
      case View::wireframe:
        return material.inputs != kNoMaterialInputs;
      case View::none:
      case View::cost:
      case View::samples:
      case View::error:
        break;
    }
    return material.uses_shading_normal() || scene_->settings.aovs.has(Aov::normal);
  }
  bool shows_colors(const Material& material) const {
    const View view = scene_->settings.view;
    const bool hides_colors = (view == View::normals || view == View::depth || view == View::ids ||
                               view == View::wireframe) &&
                              !scene_->settings.aovs.has(Aov::albedo);
    return hides_colors ? material.inputs != kNoMaterialInputs : material.uses_vertex_color();
  }

  void classify(ShapeMaterials& entry) const {
    uint32_t one_sided = 0;
    for (uint32_t i = 0; i < entry.count; ++i) {
      const uint32_t index = scene_->material_slots[entry.first + i];
      const Material* material = &materials_.materials()[index];
      if (material->hides_back()) ++one_sided;
      const Material* sides[] = {material, &materials_.materials()[material->back]};
      const size_t count = material->has_other_back() ? 2 : 1;
      for (size_t side = 0; side < count; ++side) {
        if (!sides[side]->is_opaque()) entry.is_clear = true;
        entry.has_alpha |= sides[side]->has_alpha();
        const uint32_t number = side == 0 ? index : material->back;
        entry.keep.uvs |= materials_.needs_uv(number);
        entry.keep.second_uvs |= materials_.needs_second_uv(number);
        entry.keep.tangents |= materials_.has_normal_map(number);
        entry.keep.normals |= shows_normals(*sides[side]);
        entry.keep.colors |= shows_colors(*sides[side]);
      }
    }
    if (one_sided == entry.count) {
      entry.cull = Cull::back;
    } else if (one_sided > 0) {
      entry.is_clear = entry.has_alpha = true;
    }
  }

  void build_shapes() {
    shapes_.resize(graph_.shapes.size());
    // The only mesh is hit, if the picture shows anything. Of several some may not be. Who counts
    // visits must not see which rays came before a tree was there.
    const auto meshes = std::count_if(graph_.shapes.begin(), graph_.shapes.end(),
                                      [](const GraphShape& s) { return s.shape->has_mesh(); });
    if (meshes > 1 && !scope_.all_meshes && scene_->settings.view != View::cost)
      scene_->built_when_hit = std::make_shared<DeferredBuilds>();
    const auto build_one = [&](size_t i, int threads) {
      Cancellation::check();
      const Where where{.kind = graph_.shapes[i].path.c_str()};
      const v1::Shape& shape = *graph_.shapes[i].shape;
      ShapeSource source = source_;
      source.threads = threads;
      if (!scope_.all_attributes) source.keep = shape_materials_[i].keep;
      source.deferred = scene_->built_when_hit;
      shapes_[i] =
          shape.has_csg() ? read_csg(csg_plans_[i], source) : read_shape(where, shape, source);
    };
    // Few shapes: each build uses all threads. Many: each is small beside their sum.
    if (shapes_.size() < 4 * static_cast<size_t>(std::max(source_.threads, 1))) {
      for (size_t i = 0; i < shapes_.size(); ++i) build_one(i, source_.threads);
    } else {
      for_each_parallel(shapes_.size(), source_.threads, [&](size_t i) { build_one(i, 1); });
    }
    for (size_t i = 0; i < shapes_.size(); ++i) {
      if (shapes_[i].has_clear_vertices) {
        ShapeMaterials& materials = shape_materials_[i];
        materials.is_clear = materials.has_alpha = true;
      }
    }
  }

  void add_instances() {
    for (const GraphInstance& in : graph_.instances) {
      const BuiltShape& built = shapes_[in.shape];
      if (!built.shape) continue;
      const ShapeMaterials& materials = shape_materials_[in.shape];
      scene_->instances.push_back({.shape = built.shape,
                                   .world_from_object = Transform(in.world_from_object),
                                   .casts_shadow = in.casts_shadow,
                                   .cull = materials.cull,
                                   .flip_normals = graph_.shapes[in.shape].shape->flip_normals()});
      scene_->shading.push_back({materials.first, materials.count, in.scope, materials.has_alpha});
      instance_shapes_.push_back(in.shape);
      if (names_)
        names_->instances.push_back(in.name ? *in.name : graph_.shapes[in.shape].shape->name());
      is_clear_.push_back(materials.is_clear);
      has_alpha_.push_back(materials.has_alpha);
      scene_->features.alpha |= materials.has_alpha;
    }
  }

  void add_origins() {
    auto origins = std::make_shared<Origins>(description_, std::move(graph_.ways));
    for (const CsgPlan& plan : csg_plans_) origins->add_shape(plan.solid_ways());
    size_t i = 0;
    for (const GraphInstance& in : graph_.instances) {
      if (!shapes_[in.shape].shape) continue;
      origins->add_instance(scene_->instances[i++].shape.get(), in.shape, in.way);
    }
    scene_->origins = std::move(origins);
  }

  void add_path_lights() {
    std::vector<const TriangleMesh*> meshes;
    for (const uint32_t shape : instance_shapes_) meshes.push_back(shapes_[shape].mesh.get());
    scene_->area_lights = find_area_lights(*scene_, meshes);
    scene_->environment = make_environment_sampler(scene_->background, source_.threads);
    scene_->counters["area_lights"] = scene_->area_lights.size();
    scene_->glass_albedos = make_glass_albedos(scene_->materials);
  }

  void build_accelerators() {
    const std::vector<Instance>& instances = scene_->instances;
    if (instances.empty()) return;
    const TreeSettings settings{source_.accelerator, source_.threads, source_.code};
    scene_->surfaces =
        make_instance_accelerator(instances, settings.kind, settings.threads, *settings.code);
    const auto occluders_of = [&](const std::vector<bool>& is_clear,
                                  const std::vector<bool>& counts) {
      return make_occluders(instances, is_clear, counts, scene_->surfaces, scene_->lights,
                            settings);
    };
    std::vector<bool> casts(instances.size());
    const bool has_shadows = std::any_of(scene_->lights.begin(), scene_->lights.end(),
                                         [](const Light& light) { return light.casts_shadow; });
    for (size_t i = 0; has_shadows && i < instances.size(); ++i) {
      if (!instances[i].casts_shadow) continue;
      scene_->features.shadows = true;
      casts[i] = !shades_nothing(instances[i], scene_->lights);
      if (!casts[i]) ++scene_->counters["planes_without_shadow"];
    }
    if (scene_->features.shadows) scene_->occluders = occluders_of(is_clear_, casts);
    if (scene_->area_lights.empty() && !scene_->environment) return;
    const std::vector<bool> all(instances.size(), true);
    scene_->path_occluders =
        casts == all && has_alpha_ == is_clear_ ? scene_->occluders : occluders_of(has_alpha_, all);
  }

  bool has_plain_light() const {
    const auto is_plain = [&](const Light& light) {
      const bool whole_shadow = light.casts_shadow && light.shadow_intensity == 1;
      return !light.ambient_attenuated && (whole_shadow || !scene_->features.shadows);
    };
    return !scene_->occluders.clear && scene_->fog.kind == FogKind::none &&
           std::ranges::all_of(scene_->lights, is_plain);
  }

  void count() {
    CounterMap& counters = scene_->counters;
    counters["materials_total"] = static_cast<uint64_t>(description_.materials_size());
    counters["materials_used"] = scene_->materials.size();
    counters["objects_total"] = static_cast<uint64_t>(description_.objects_size());
    counters["objects_used"] = graph_.objects_used;
    counters["shapes"] = shapes_.size();
    counters["instances"] = scene_->instances.size();
    counters["lights_used"] = scene_->lights.size();
    counters["lights_off"] = graph_.lights_off;
    counters["nodes_hidden"] = graph_.hidden_nodes;
    counters["nodes_flat"] = graph_.flat_nodes;
    counters["textures_total"] = static_cast<uint64_t>(description_.textures_size());
    counters["textures_used"] = texture_count_;
    counters["textures_skipped"] = counters["textures_total"] - texture_count_;
    counters["texture_bytes"] = textures_.texel_bytes();
    uint64_t& mesh_bytes = counters["mesh_bytes"];
    uint64_t& mesh_bytes_dropped = counters["mesh_bytes_dropped"];
    uint64_t& attributes_dropped = counters["attributes_dropped"];
    uint64_t& triangles = counters["triangles"];
    uint64_t& dropped = counters["triangles_dropped"];
    uint64_t& deferred = counters["mesh_builds_deferred"];
    uint64_t& scans = counters["small_trees_skipped"];
    for (const Accelerator* tree :
         {scene_->surfaces.get(), scene_->occluders.clear.get(),
          scene_->occluders.opaque == scene_->surfaces ? nullptr : scene_->occluders.opaque.get()})
      scans += tree != nullptr && tree->statistics().leaves == 0 ? 1 : 0;
    for (const BuiltShape& built : shapes_) {
      triangles += built.triangles;
      dropped += built.triangles_dropped;
      if (built.is_deferred) ++deferred;
      mesh_bytes += built.bytes;
      mesh_bytes_dropped += built.bytes_dropped;
      attributes_dropped += built.attributes_dropped;
    }
    counters["features_absent"] = static_cast<uint64_t>(scene_->features.absent());
    counters["instances_opaque"] =
        static_cast<uint64_t>(std::count(is_clear_.begin(), is_clear_.end(), false));
    counters["nodes_dropped"] = graph_.flat_nodes;
  }

  const v1::Scene& description_;
  const v1::FrameSettings& frame_;
  BuildScope scope_;
  SceneNames* const names_;
  ShapeSource source_;
  TextureTable textures_;
  MaterialTable materials_;
  size_t texture_count_ = 0;
  std::shared_ptr<Scene> scene_ = std::make_shared<Scene>();
  SceneGraph graph_;
  std::vector<ShapeMaterials> shape_materials_;  // one a graph shape
  std::vector<CsgPlan> csg_plans_;               // one a graph shape, empty for most
  std::vector<BuiltShape> shapes_;               // one a graph shape
  std::vector<uint32_t> instance_shapes_;        // one an instance: its graph shape
  std::vector<bool> is_clear_, has_alpha_;       // one an instance
};

}  // namespace

std::shared_ptr<const Scene> build_scene(const v1::Scene& description, const BlobStore& blobs,
                                         const v1::FrameSettings& frame, int threads,
                                         const Sharing& sharing, const BuildScope& scope,
                                         SceneNames* names) {
  return SceneBuilder(description, blobs, frame, threads, sharing, scope, names).build();
}

namespace {

void tell_dropped(const CounterMap& counters, const char* name, const char* what, const char* why,
                  std::vector<std::string>& warnings) {
  const auto count = counters.find(name);
  if (count == counters.end() || count->second == 0) return;
  warnings.push_back(fmt::format("{} {}: left out", counted(count->second, what), why));
}

}  // namespace

std::vector<std::string> mesh_warnings(const CounterMap& counters) {
  std::vector<std::string> warnings;
  tell_dropped(counters, "triangles_dropped", "triangle", "without an area", warnings);
  return warnings;
}

std::vector<std::string> build_warnings(const CounterMap& counters) {
  std::vector<std::string> warnings = mesh_warnings(counters);
  tell_dropped(counters, "nodes_dropped", "node", "scaled to nothing or out of range", warnings);
  return warnings;
}

}  // namespace tessera
