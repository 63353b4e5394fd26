#include "scenes/formats/obj/mtl_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

#include "base/file.h"

namespace tessera {
namespace {

using Rgb = std::array<float, 3>;

/// One newmtl block as written.
struct Entry {
  std::string name;
  std::optional<Rgb> ambient, diffuse, specular, emission, filter;
  std::optional<float> exponent, refractive_index, dissolve, transparency;
  std::optional<int> illumination;
};

void put(const Rgb& from, v1::Color* to) {
  to->set_r(from[0]);
  to->set_g(from[1]);
  to->set_b(from[2]);
}

Rgb scaled(Rgb color, float by) {
  for (float& c : color) c *= by;
  return color;
}

bool is_black(const Rgb& c) { return c[0] == 0 && c[1] == 0 && c[2] == 0; }

/// The illumination models that are named by number: what each switches on.
struct Model {
  bool ambient = true, highlight = true, mirror = false, refracts = false, glass = false;
};

Model model_of(int number) {
  switch (number) {
    case 0:
      return {false, false, false, false, false};
    case 1:
      return {true, false, false, false, false};
    case 3:
    case 5:
      return {true, true, true, false, false};
    case 4:
      return {true, true, true, false, true};
    case 6:
    case 7:
      return {true, true, false, true, true};  // the mirrored part comes with Fresnel
    case 8:
      return {true, true, true, false, false};
    case 9:
      return {true, true, false, false, true};
    default:
      return {};
  }
}

/// d and Tr say the same thing in two ways; where both are there, d holds. Tf counts only for the
/// models of glass, since many programs write it for opaque materials too.
float transparency_of(const Entry& entry, const Model& model) {
  float transparency = 0;
  if (entry.dissolve)
    transparency = 1 - *entry.dissolve;
  else if (entry.transparency)
    transparency = *entry.transparency;
  if (transparency == 0 && model.glass && entry.filter)
    transparency = ((*entry.filter)[0] + (*entry.filter)[1] + (*entry.filter)[2]) / 3;
  return std::clamp(transparency, 0.f, 1.f);
}

v1::Material to_material(const Entry& entry) {
  v1::Material material;
  material.set_name(entry.name);
  const Rgb grey{.8f, .8f, .8f};
  const Rgb diffuse = entry.diffuse.value_or(grey);
  if (entry.illumination == 0) {
    put(diffuse, material.mutable_unlit()->mutable_color()->mutable_value());
    return material;
  }
  const Model model = model_of(entry.illumination.value_or(2));
  const float transparency = transparency_of(entry, model);
  v1::Classic& classic = *material.mutable_classic();
  if (entry.ambient) put(*entry.ambient, classic.mutable_ambient()->mutable_value());
  put(scaled(diffuse, model.refracts ? 1 - transparency : 1),
      classic.mutable_diffuse()->mutable_value());
  const Rgb specular = entry.specular.value_or(Rgb{});
  if (model.highlight && !is_black(specular))
    put(specular, classic.mutable_specular()->mutable_value());
  if (model.mirror && !is_black(specular))
    put(specular, classic.mutable_reflectivity()->mutable_value());
  if (entry.exponent) classic.mutable_shininess()->set_value(*entry.exponent);
  if (entry.emission && !is_black(*entry.emission))
    put(*entry.emission, classic.mutable_emission()->mutable_value());
  if (transparency > 0) {
    classic.mutable_transparency()->set_value(transparency);
    classic.set_transmission(model.refracts ? v1::Classic::REFRACT : v1::Classic::STRAIGHT);
    if (model.refracts) classic.set_refractive_index(entry.refractive_index.value_or(1.5f));
  }
  return material;
}

class MtlReader {
 public:
  MtlReader(LineReader& in, MtlMaterials& materials, Warnings& warnings)
      : in_(in), materials_(materials), warnings_(warnings) {}

  void read() {
    while (in_.next_line()) {
      const std::string keyword(in_.word());
      if (keyword.empty() || keyword.front() == '#') continue;
      if (keyword == "newmtl")
        begin();
      else if (!color(keyword) && !number(keyword))
        skip(keyword);
    }
    finish();
  }

 private:
  void begin() {
    finish();
    entry_.emplace();
    entry_->name = to_utf8(in_.rest());
    if (entry_->name.empty()) throw in_.error("newmtl without a name", "a material's name");
  }

  void finish() {
    if (!entry_) return;
    if (!materials_.try_emplace(entry_->name, to_material(*entry_)).second)
      warnings_.add(fmt::format("material '{}' comes twice; the first one is taken", entry_->name));
    entry_.reset();
  }

  Entry& entry() {
    if (!entry_) throw in_.error(in_.quoted_word(), "newmtl before it");
    return *entry_;
  }

  bool color(const std::string& keyword) {
    std::optional<Rgb> Entry::*member = nullptr;
    if (keyword == "Ka") member = &Entry::ambient;
    if (keyword == "Kd") member = &Entry::diffuse;
    if (keyword == "Ks") member = &Entry::specular;
    if (keyword == "Ke") member = &Entry::emission;
    if (keyword == "Tf") member = &Entry::filter;
    if (!member) return false;
    Entry& target = entry();
    if (in_.at_line_end()) throw in_.error("the line ends here", "three colour components");
    if (in_.peek() == 's' || in_.peek() == 'x') {
      warnings_.add(fmt::format("{} {} is not read", keyword, in_.word()));
      return true;
    }
    const float r = in_.number("a colour component");
    const auto g = in_.optional_number("a colour component");
    const auto b = in_.optional_number("a colour component");
    if (g && !b) throw in_.error("two colour components", "one or three");
    target.*member = Rgb{r, g.value_or(r), b.value_or(r)};
    for (float& c : *(target.*member)) {
      if (c >= 0) continue;
      warnings_.add(fmt::format("a negative component of {} is taken as 0", keyword));
      c = 0;
    }
    return true;
  }

  bool number(const std::string& keyword) {
    if (keyword == "d") {
      Entry& target = entry();
      in_.at_line_end();
      if (in_.peek() == '-') warnings_.add(fmt::format("d {} is read as plain d", in_.word()));
      target.dissolve = in_.number("a share of 0 to 1");
    } else if (keyword == "Tr") {
      entry().transparency = in_.number("a share of 0 to 1");
    } else if (keyword == "Ns") {
      entry().exponent = std::max(0.f, in_.number("an exponent"));
    } else if (keyword == "Ni") {
      const float index = in_.number("a refractive index");
      if (index <= 0)
        warnings_.add("a refractive index (Ni) that is not above 0 is left out");
      else
        entry().refractive_index = index;
    } else if (keyword == "illum") {
      const float model = in_.number("an illumination model of 0 to 10");
      if (!(model >= 0 && model <= 10) || model != static_cast<float>(static_cast<int>(model)))
        throw in_.error(in_.quoted_word(), "an illumination model of 0 to 10");
      entry().illumination = static_cast<int>(model);
    } else {
      return false;
    }
    return true;
  }

  void skip(const std::string& keyword) {
    constexpr std::array<std::string_view, 13> kPbr{"Pr",    "Pm",     "Ps",  "Pc",   "Pcr",
                                                    "aniso", "anisor", "Ke",  "norm", "bump",
                                                    "disp",  "decal",  "refl"};
    const bool map = keyword.starts_with("map_") || keyword == "bump" || keyword == "disp" ||
                     keyword == "decal" || keyword == "refl" || keyword == "norm";
    if (map)
      warnings_.add(fmt::format("texture ({}) is not read yet", keyword));
    else if (std::find(kPbr.begin(), kPbr.end(), keyword) != kPbr.end())
      warnings_.add(fmt::format("physical parameter '{}' is not read yet", keyword));
    else if (std::any_of(keyword.begin(), keyword.end(),
                         [](char c) { return static_cast<unsigned char>(c) < 0x20; }))
      throw in_.error("binary data", "the text of an MTL file");
    else
      warnings_.add(fmt::format("unknown statement {} is left out", in_.quoted_word()));
  }

  LineReader& in_;
  MtlMaterials& materials_;
  Warnings& warnings_;
  std::optional<Entry> entry_;
};

}  // namespace

void read_mtl(LineReader& reader, MtlMaterials& materials, Warnings& warnings) {
  MtlReader(reader, materials, warnings).read();
}

}  // namespace tessera
