#include "scenes/formats/obj/mtl_material.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scenes/import/picture_light.h"

namespace tessera {
namespace {

using Rgb = MtlEntry::Rgb;
using Encoding = v1::Texture::Image::Encoding;
constexpr Rgb kWhiteRgb{1, 1, 1};

bool is_black(const Rgb& c) {
  return c[0] <= kMtlRounding && c[1] <= kMtlRounding && c[2] <= kMtlRounding;
}

/// The illumination models that are named by number: what each switches on.
struct Model {
  bool highlight = true, mirror = false, refracts = false, glass = false;
};

Model model_of(int number) {
  switch (number) {
    case 1:
      return {false, false, false, false};
    case 3:
    case 5:
    case 8:
      return {true, true, false, false};
    case 4:
      return {true, true, false, true};
    case 6:
    case 7:
      return {true, false, true, true};  // the mirrored part comes with Fresnel
    case 9:
      return {true, false, false, true};
    default:
      return {};
  }
}

class Converter {
 public:
  Converter(const MtlEntry& entry, MtlLibrary& library, Warnings& warnings)
      : entry_(entry),
        library_(library),
        warnings_(warnings),
        model_(model_of(entry.illumination.value_or(2))),
        transparency_(transparency()) {}

  v1::Material convert() {
    material_.set_name(entry_.name);
    if (is_physical())
      physical();
    else if (entry_.illumination == 0)
      color(diffuse(), "map_kd", material_.mutable_unlit()->mutable_color());
    else
      classic();
    coverage();
    relief();
    return std::move(material_);
  }

 private:
  const MtlMap* map(const char* statement) const {
    const auto found = entry_.maps.find(statement);
    return found == entry_.maps.end() ? nullptr : &found->second;
  }
  std::optional<float> number(const char* statement) const {
    const auto found = entry_.numbers.find(statement);
    return found == entry_.numbers.end() ? std::nullopt : std::optional(found->second);
  }

  /// d and Tr say the same thing in two ways; where both are there, d holds. Tf counts only for the
  /// models of glass, since many programs write it for opaque materials too.
  double transparency() {
    double share = 0;
    if (const auto dissolve = number("d"))
      share = 1 - *dissolve;
    else if (const auto opposite = number("Tr"))
      share = is_opaque_by_mistake(*opposite) ? 0 : *opposite;
    if (share <= kMtlRounding && model_.glass && entry_.filter)
      share = ((*entry_.filter)[0] + (*entry_.filter)[1] + (*entry_.filter)[2]) / 3;
    if (share <= kMtlRounding) return 0;
    return share >= 1 - kMtlRounding ? 1 : share;
  }

  /// Exporters that take Tr for d write 1 for what is opaque. Glass and mirrors are seen even where
  /// they are wholly clear.
  bool is_opaque_by_mistake(double opposite) {
    if (opposite < 1 - kMtlRounding || model_.refracts || (model_.glass && model_.mirror))
      return false;
    warnings_.repair(
        fmt::format("{:g}, so that nothing would be seen", opposite), "a share below 1, or d",
        "0 is taken", [this] { return entry_.transparency_place; }, "Tr");
    return true;
  }

  bool is_physical() const {
    const auto has = [&](const char* name) {
      return entry_.numbers.contains(name) || entry_.maps.contains(name);
    };
    return has("Pr") || has("Pm") || has("Pc") || has("map_pr") || has("map_pm") ||
           has("map_orm") || has("map_rma");
  }

  /// Programs that write a map often write black beneath it, which would hide it.
  Rgb beneath(const char* statement, const std::optional<Rgb>& color, const Rgb& without) {
    if (!map(statement)) return color.value_or(without);
    if (!color || !is_black(*color)) return color.value_or(kWhiteRgb);
    warnings_.add(fmt::format("the black colour beneath {} is taken as white", statement));
    return kWhiteRgb;
  }
  Rgb diffuse() { return beneath("map_kd", entry_.diffuse, {.8f, .8f, .8f}); }

  void color(Rgb value, const char* statement, v1::ColorInput* input) {
    if (const MtlMap* const m = map(statement)) {
      input->set_texture(texture(*m, v1::Texture::Image::ENCODING_SRGB));
      for (float& c : value) c *= static_cast<float>(m->gain);
    }
    v1::Color& out = *input->mutable_value();
    out.set_r(value[0]);
    out.set_g(value[1]);
    out.set_b(value[2]);
  }

  using Channel = std::optional<v1::FloatInput::Channel>;

  void share(double value, const char* statement, v1::FloatInput* input, Channel channel = {},
             PictureChannel usual = PictureChannel::luminance) {
    scaled(value, statement, input, channel, usual);
    input->set_value(std::clamp(input->value(), 0.0, 1.0));
  }

  /// The map's own option says which channel of its picture holds the number; else `channel`, and
  /// without one `usual`.
  void scaled(double value, const char* statement, v1::FloatInput* input, Channel channel = {},
              PictureChannel usual = PictureChannel::luminance) {
    if (const MtlMap* const m = map(statement)) {
      if (m->channel || m->luminance) channel = m->channel;
      if (m->luminance) usual = PictureChannel::luminance;
      input->set_texture(texture(*m, v1::Texture::Image::ENCODING_LINEAR,
                                 channel ? std::nullopt : std::optional(usual)));
      if (channel) input->set_channel(*channel);
      value *= m->gain;
    }
    input->set_value(value);
  }

  void classic() {
    v1::Classic& out = *material_.mutable_classic();
    Rgb seen = diffuse();
    // Of a refracting material's diffuse light the share 1 - transparency is left.
    if (model_.refracts)
      for (float& c : seen) c *= static_cast<float>(1 - transparency_);
    color(seen, "map_kd", out.mutable_diffuse());
    // Many tools write a white Ka whatever the colour is; no surface sends more on than it does of
    // other light.
    Rgb ambient = seen;
    for (size_t c = 0; entry_.ambient && c < ambient.size(); ++c)
      ambient[c] = std::min(ambient[c], (*entry_.ambient)[c]);
    color(ambient, map("map_ka") ? "map_ka" : "map_kd", out.mutable_ambient());
    const Rgb specular = beneath("map_ks", entry_.specular, {});
    // Exporters write an exponent of 0 for a surface that is fully rough, which has no highlight.
    const auto exponent = number("Ns");
    const bool is_rough = exponent && *exponent <= kMtlRounding;
    if (model_.highlight && !is_rough && !is_black(specular))
      color(specular, "map_ks", out.mutable_specular());
    if (model_.mirror && !is_black(specular)) color(specular, "map_ks", out.mutable_reflectivity());
    if (exponent && !is_rough) out.mutable_shininess()->set_value(*exponent);
    if (map("map_ns") && !is_rough)
      scaled(exponent.value_or(100), "map_ns", out.mutable_shininess());
    const Rgb emission = beneath("map_ke", entry_.emission, {});
    if (!is_black(emission)) color(emission, "map_ke", out.mutable_emission());
    if (transparency_ == 0) return;
    out.mutable_transparency()->set_value(transparency_);
    out.set_transmission(model_.refracts ? v1::Classic::REFRACT : v1::Classic::STRAIGHT);
    if (model_.refracts) out.set_refractive_index(number("Ni").value_or(1.5f));
  }

  void physical() {
    v1::Physical& out = *material_.mutable_physical();
    color(diffuse(), "map_kd", out.mutable_base_color());
    const auto given = [&](const char* name, const char* map_name, double without) {
      const auto value = number(name);
      return std::clamp(double{value.value_or(static_cast<float>(map(map_name) ? 1 : without))},
                        0.0, 1.0);
    };
    // Of a highlight's exponent, where that is all there is (Walter et al. 2007, section 5.2).
    const auto exponent = number("Ns");
    const double rough = exponent ? std::sqrt(std::sqrt(2 / (double{*exponent} + 2))) : 0.5;
    if (map("map_orm") || map("map_rma")) {
      const bool orm = map("map_orm") != nullptr;
      const char* const packed = orm ? "map_orm" : "map_rma";
      share(1, packed, out.mutable_occlusion(), orm ? v1::FloatInput::RED : v1::FloatInput::BLUE);
      share(given("Pr", packed, rough), packed, out.mutable_roughness(),
            orm ? v1::FloatInput::GREEN : v1::FloatInput::RED);
      share(given("Pm", packed, 0), packed, out.mutable_metallic(),
            orm ? v1::FloatInput::BLUE : v1::FloatInput::GREEN);
    } else {
      share(given("Pr", "map_pr", rough), "map_pr", out.mutable_roughness());
      share(given("Pm", "map_pm", 0), "map_pm", out.mutable_metallic());
    }
    if (const double coat = given("Pc", "map_pc", 0); coat > 0) {
      share(coat, "map_pc", out.mutable_clearcoat());
      share(given("Pcr", "map_pcr", 0), "map_pcr", out.mutable_clearcoat_roughness());
    }
    const Rgb emission = beneath("map_ke", entry_.emission, {});
    if (!is_black(emission)) color(emission, "map_ke", out.mutable_emission());
    const auto index = number("Ni");
    if (index && *index > 1 + kMtlRounding) out.set_refractive_index(*index);
    if (transparency_ == 0) return;
    if (model_.refracts)
      out.mutable_transmission()->set_value(transparency_);
    else
      out.mutable_transparency()->set_value(transparency_);
  }

  /// A map of opacity that is the colour's own picture means its alpha, which acts by itself,
  /// unless it names another channel; where nothing speaks of clearness, alpha means nothing.
  void coverage() {
    const MtlMap* const clear = map("map_d");
    const MtlMap* const seen = map("map_kd");
    const bool is_alpha = clear && !clear->luminance &&
                          clear->channel.value_or(v1::FloatInput::ALPHA) == v1::FloatInput::ALPHA;
    if (clear && !(seen && seen->file == clear->file && is_alpha))
      share(1, "map_d", material_.mutable_opacity(), {}, PictureChannel::alpha_or_luminance);
    else if (!clear && seen && transparency_ == 0)
      material_.set_alpha(v1::Material::ALPHA_OPAQUE);
  }

  void relief() {
    if (const MtlMap* const normals = map("norm")) {
      material_.set_normal_map(texture(*normals, v1::Texture::Image::ENCODING_LINEAR));
      if (normals->multiplier != 1) material_.set_normal_scale(normals->multiplier);
    }
    if (const MtlMap* const heights = map("bump"))
      scaled(heights->multiplier, "bump", material_.mutable_bump());
  }

  /// The name of the texture that the map asks for.
  std::string texture(const MtlMap& m, Encoding usual,
                      std::optional<PictureChannel> channel = std::nullopt) {
    v1::Texture made;
    v1::Texture::Image& image = *made.mutable_image();
    image.set_file(m.file);
    if (m.encoding)
      image.set_encoding(*m.encoding);
    else
      set_integer_encoding(usual, image);
    if (m.clamp) {
      image.set_wrap_s(v1::Texture::Image::CLAMP);
      image.set_wrap_t(v1::Texture::Image::CLAMP);
    }
    if (m.scale != MtlMap{}.scale || m.offset != MtlMap{}.offset) {
      const auto put = [](const std::array<double, 3>& from, v1::Vec3* to) {
        to->set_x(from[0]);
        to->set_y(from[1]);
        to->set_z(from[2]);
      };
      put(m.offset, made.mutable_transform()->add_steps()->mutable_translate());
      put(m.scale, made.mutable_transform()->add_steps()->mutable_scale());
    }
    made.set_name(m.file);
    if (!channel) return library_.textures.add(std::move(made));
    // Of a coloured picture another texture than the one with its colours.
    made.set_name(m.file +
                  (*channel == PictureChannel::luminance ? " (luminance)" : " (alpha, luminance)"));
    const std::string name = library_.textures.add(std::move(made));
    library_.picture_channels.emplace(name, *channel);
    return name;
  }

  const MtlEntry& entry_;
  MtlLibrary& library_;
  Warnings& warnings_;
  Model model_;
  double transparency_;
  v1::Material material_;
};

}  // namespace

void add_mtl_material(const MtlEntry& entry, MtlLibrary& library, Warnings& warnings) {
  if (library.materials.contains(entry.name)) {
    warnings.add(fmt::format("material '{}' comes twice; the first one is taken", entry.name));
    return;
  }
  library.materials.emplace(entry.name, Converter(entry, library, warnings).convert());
}

}  // namespace tessera
