#include "front/picture_warnings.h"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "base/plural.h"
#include "image/image_file.h"
#include "job/scene_motion.h"
#include "proto/wire/printable.h"
#include "renderer/math/transform.h"
#include "renderer/scene/read_settings.h"
#include "renderer/scene/scene_builder.h"
#include "scenes/import/to_affine.h"

namespace tessera {
namespace {

namespace pb = google::protobuf;

/// Whether `wanted` is true of `message` or of one inside it.
bool any_message(const pb::Message& message,
                 const std::function<bool(const pb::Message&)>& wanted) {
  if (wanted(message)) return true;
  const pb::Reflection& reflection = *message.GetReflection();
  std::vector<const pb::FieldDescriptor*> fields;
  reflection.ListFields(message, &fields);
  for (const pb::FieldDescriptor* field : fields) {
    if (field->cpp_type() != pb::FieldDescriptor::CPPTYPE_MESSAGE || field->is_map()) continue;
    const int count = field->is_repeated() ? reflection.FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i) {
      const pb::Message& inside = field->is_repeated()
                                      ? reflection.GetRepeatedMessage(message, field, i)
                                      : reflection.GetMessage(message, field);
      if (any_message(inside, wanted)) return true;
    }
  }
  return false;
}

bool is_black(const v1::Color& color) { return color.r() == 0 && color.g() == 0 && color.b() == 0; }

bool emits(const v1::Light& light) {
  const bool dark = (light.has_intensity() && light.intensity() == 0) ||
                    (light.has_color() && is_black(light.color()));
  return !light.off() && (!dark || light.ambient_intensity() != 0);
}

bool emits(const v1::Background& background) {
  if (background.has_cube()) return true;
  switch (background.kind_case()) {
    case v1::Background::KIND_NOT_SET:
      return false;
    case v1::Background::kSolid:
      return !is_black(background.solid());
    case v1::Background::kGradient:
      return !is_black(background.gradient().sky()) || !is_black(background.gradient().ground());
    default:
      return true;
  }
}

/// A light, a material that glows by itself, or a fog of its own colour.
bool may_shine(const pb::Message& message) {
  if (const auto* light = dynamic_cast<const v1::Light*>(&message)) return emits(*light);
  if (const auto* material = dynamic_cast<const v1::Material*>(&message)) {
    return material->has_unlit() || material->classic().has_emission() ||
           material->physical().has_emission();
  }
  return message.GetDescriptor() == v1::Fog::descriptor();
}

/// What is odd about numbers of one kind: told of the first, with how many others there are.
class OddNumbers {
 public:
  void add(std::string where) {
    if (count_++ == 0) first_ = std::move(where);
  }
  void tell(std::string_view expected, std::vector<std::string>& warnings) const {
    if (count_ == 0) return;
    const std::string others =
        count_ > 1 ? fmt::format("; {} more like it", count_ - 1) : std::string();
    warnings.push_back(fmt::format("{}; {}{}", first_, expected, others));
  }

 private:
  std::string first_;
  size_t count_ = 0;
};

std::string named(std::string_view kind, const std::string& name) {
  return name.empty() ? std::string(kind) : fmt::format("{} '{}'", kind, printable(name));
}

/// A little above 1 is what rounding makes of 1.
bool is_above_one(const v1::Color& color) {
  constexpr double kOne = 1 + 1e-6;
  return color.r() > kOne || color.g() > kOne || color.b() > kOne;
}

bool has_negative(const v1::Color& color) {
  return color.r() < 0 || color.g() < 0 || color.b() < 0;
}

std::string numbers_of(const v1::Color& color) {
  return fmt::format("({:g}, {:g}, {:g})", color.r(), color.g(), color.b());
}

/// Nodes whose transform leaves nothing of what they hold.
void add_flat_nodes(const v1::Scene& scene, std::vector<std::string>& warnings) {
  OddNumbers flat;
  any_message(scene, [&flat](const pb::Message& message) {
    const auto* node = dynamic_cast<const v1::Node*>(&message);
    if (node && !node->hidden() && node->keys().empty() && node->transform().steps_size() > 0 &&
        !is_invertible(to_affine(node->transform()))) {
      flat.add(fmt::format("{}: its transform makes it flat", named("node", node->name())));
    }
    return false;
  });
  flat.tell("expected one that keeps three dimensions, so that something is seen", warnings);
}

/// Surfaces that send back more light than they get, and lights that take some away.
void add_odd_numbers(const v1::Scene& scene, std::vector<std::string>& warnings) {
  OddNumbers reflected, taken;
  for (const v1::Material& material : scene.materials()) {
    const v1::ColorInput& color =
        material.has_physical() ? material.physical().base_color() : material.classic().diffuse();
    if (!color.texture().empty() || !is_above_one(color.value())) continue;
    reflected.add(fmt::format("{}: {} is {}", named("material", material.name()),
                              material.has_physical() ? "base_color" : "diffuse",
                              numbers_of(color.value())));
  }
  const auto check = [&taken](const std::string& name, const v1::Light& light) {
    if (light.intensity() < 0) {
      taken.add(fmt::format("{}: intensity is {:g}", name, light.intensity()));
    } else if (has_negative(light.color())) {
      taken.add(fmt::format("{}: color is {}", name, numbers_of(light.color())));
    }
  };
  any_message(scene, [&check](const pb::Message& message) {
    if (const auto* node = dynamic_cast<const v1::Node*>(&message)) {
      check(named("light", node->light().name()), node->light());
    } else if (const auto* camera = dynamic_cast<const v1::Camera*>(&message)) {
      check("headlight of " + named("camera", camera->name()), camera->headlight());
    }
    return false;
  });
  reflected.tell("expected at most 1, as more light would come back than came", warnings);
  taken.tell("expected 0 or more, as it takes light away", warnings);
}

std::string kind_of(const RenderOptions& options, const v1::Scene& scene) {
  return options.integrator.value_or(scene.settings().integrator().kind());
}

bool is_all_black(const RenderOptions& options, const v1::Scene& scene) {
  const v1::IntegratorSettings& integrator = scene.settings().integrator();
  const std::string kind = kind_of(options, scene);
  if (!shows_light(kind)) return false;
  return is_black(integrator.ambient()) && !emits(scene.background()) &&
         !any_message(scene, may_shine);
}

}  // namespace

std::vector<std::string> picture_warnings(const RenderOptions& options, const LoadedScene& loaded) {
  std::vector<std::string> warnings;
  if (is_all_black(options, loaded.scene)) {
    warnings.push_back("the scene has no light, emission or background: the picture will be black");
  }
  add_flat_nodes(loaded.scene, warnings);
  if (shows_light(kind_of(options, loaded.scene))) add_odd_numbers(loaded.scene, warnings);
  const bool several = options.frames && options.frames->size() > 1;
  if (several && !loaded.depends_on_frame && !moves(loaded.scene)) {
    warnings.push_back("nothing in the scene depends on the frame: all pictures will be the same");
  }
  return warnings;
}

std::vector<std::string> scene_warnings(const RenderOptions& options, const LoadedScene& loaded) {
  std::vector<std::string> all;
  for (const auto& warnings : {loaded.warnings, picture_warnings(options, loaded)}) {
    for (const std::string& warning : warnings) {
      if (std::find(all.begin(), all.end(), warning) == all.end()) all.push_back(warning);
    }
  }
  return all;
}

std::vector<std::string> located_mesh_warnings(const CounterMap& counters,
                                               const std::string& scene) {
  std::vector<std::string> warnings = mesh_warnings(counters);
  if (!scene.empty())
    for (std::string& warning : warnings) warning = fmt::format("{}: {}", scene, warning);
  return warnings;
}

bool has_strokes_alone(const v1::Scene& scene) {
  bool has_shapes = false;
  const bool has_others = any_message(scene, [&](const pb::Message& message) {
    const auto* node = dynamic_cast<const v1::Node*>(&message);
    if (!node || !node->has_shape()) return false;
    has_shapes = true;
    return !node->casts_no_shadow();
  });
  return has_shapes && !has_others;
}

bool shows_whole_frame(const Film& film, const v1::FrameSettings& frame) {
  return film.width() == static_cast<int>(frame.width()) &&
         film.height() == static_cast<int>(frame.height());
}

std::vector<std::string> report_warnings(const JobReport& report, const PictureOrigin& origin) {
  const auto count = [](const CounterMap& counters, const char* name) {
    const auto at = counters.find(name);
    return at == counters.end() ? 0 : at->second;
  };
  std::vector<std::string> warnings = located_mesh_warnings(report.build_counters, origin.scene);
  if (const uint64_t lost = count(report.counters, "nan_samples"); lost > 0) {
    warnings.push_back(fmt::format(
        "{} had no colour that a pixel can hold and count as black; expected light and colours "
        "whose products stay below 1e38",
        counted(lost, "sample")));
  }
  // What was kept from before has no counts.
  const bool is_traced = report.end == JobReport::End::done && report.tiles_restored == 0;
  if (is_traced && origin.is_whole && count(report.counters, "hits") == 0) {
    const bool has_surfaces = count(report.build_counters, "instances") > 0;
    warnings.push_back(
        fmt::format("no ray meets a surface, so that only the background is seen; expected {}",
                    has_surfaces && origin.is_of_strokes
                        ? "a larger --size or more --spp, as points and lines may be thinner than "
                          "a pixel, or a camera that looks at them"
                    : has_surfaces ? "a camera that looks at what there is, as with --frame-all"
                    : count(report.build_counters, "nodes_hidden") > 0 ? "nodes that are not hidden"
                                                                       : "nodes with shapes"));
  }
  return warnings;
}

std::vector<std::string> brightness_warnings(const v1::FrameSettings& frame,
                                             std::span<const std::filesystem::path> paths,
                                             const Film& film, const OutputSettings& settings) {
  if (!shows_light(frame.integrator()) || std::all_of(paths.begin(), paths.end(), holds_floats))
    return {};
  constexpr double kMuch = 0.2, kStays = 0.02;  // of the pixels
  const bool cuts = settings.tone_curve == ToneCurve::clamp && !settings.color_management;
  if (!cuts) return {};
  const double white = std::exp2(-settings.exposure);
  std::vector<float> brighter;  // the darkest channels of pixels that are white
  const std::span<const float> values = film.values();
  const auto channels = static_cast<size_t>(film.channels());
  for (size_t i = 0; i < values.size(); i += channels) {
    const float darkest = std::min({values[i], values[i + 1], values[i + 2]});
    if (darkest > white) brighter.push_back(darkest);
  }
  const size_t pixels = values.size() / channels;
  const double share = static_cast<double>(brighter.size()) / static_cast<double>(pixels);
  if (share < kMuch) return {};
  const auto staying =
      brighter.begin() + static_cast<ptrdiff_t>(kStays * static_cast<double>(pixels));
  std::nth_element(brighter.begin(), staying, brighter.end(), std::greater<>());
  const double stops = std::floor(-2 * std::log2(double{*staying})) / 2;  // by halves
  return {fmt::format(
      "{:.0f} % of the picture is brighter than white; --exposure {:g} would show it, or "
      "--tone-map filmic",
      100 * share, std::max(stops, -100.0))};
}

std::vector<std::string> file_warnings(const RenderOptions& options, const LoadedScene& loaded) {
  std::vector<std::string> warnings;
  const std::string kind = kind_of(options, loaded.scene);
  if (kind != "depth" && kind != "cost" && kind != "samples" && kind != "error") return warnings;
  for (const auto& path : picture_paths(options)) {
    if (holds_floats(path)) continue;
    warnings.push_back(
        fmt::format("'{}' shows numbers, and '{}' holds only those from 0 to 1; expected .exr",
                    kind, path.string()));
  }
  return warnings;
}

}  // namespace tessera
