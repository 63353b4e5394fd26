#include "scenes/formats/obj/mtl_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>
#include <optional>

#include "base/file.h"

namespace tessera {
namespace {

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return out;
}

/// The one name of a map statement, whose case and spelling programs do not agree on; empty for
/// what is none.
std::string map_statement(std::string_view keyword) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 7> kSpellings{
      {{"map_bump", "bump"},
       {"map_opacity", "map_d"},
       {"map_kn", "norm"},
       {"map_norm", "norm"},
       {"map_emissive", "map_ke"},
       {"map_occlusionroughnessmetallic", "map_orm"},
       {"map_roughnessmetallicocclusion", "map_rma"}}};
  const std::string name = lower(keyword);
  for (const auto& [spelling, statement] : kSpellings)
    if (name == spelling) return std::string(statement);
  const bool is_map = name.starts_with("map_") || name == "bump" || name == "norm" ||
                      name == "disp" || name == "decal" || name == "refl";
  return is_map ? name : "";
}

class MtlReader {
 public:
  MtlReader(LineReader& in, const MtlPictureFinder& find, MtlLibrary& library, Warnings& warnings)
      : in_(in), find_picture_(find), library_(library), warnings_(warnings) {}

  void read() {
    while (in_.next_line()) {
      const std::string keyword(in_.word());
      if (keyword.empty() || keyword.front() == '#') continue;
      try {
        statement(keyword);
      } catch (const Error& problem) {
        if (problem.code() != ExitCode::bad_scene || problem.diagnostics().empty()) throw;
        warnings_.repair(problem, "the statement is left out");
      }
    }
    finish();
  }

 private:
  void statement(const std::string& keyword) {
    if (keyword == "newmtl")
      begin();
    else if (!color(keyword) && !number(keyword) && !map(keyword))
      skip(keyword);
  }

  void begin() {
    finish();
    entry_.name = to_utf8(in_.rest());
    if (entry_.name.empty()) throw in_.error("newmtl without a name", "a material's name");
  }

  void finish() {
    if (!entry_.name.empty()) add_mtl_material(entry_, library_, warnings_);
    entry_ = {};
  }

  void add_warning(std::string_view what) {
    warnings_.add(what, [&] { return in_.place(); });
  }

  MtlEntry& entry() {
    if (entry_.name.empty()) throw in_.error(in_.quoted_word(), "newmtl before it");
    return entry_;
  }

  bool color(const std::string& keyword) {
    std::optional<MtlEntry::Rgb> MtlEntry::*member = nullptr;
    if (keyword == "Ka") member = &MtlEntry::ambient;
    if (keyword == "Kd") member = &MtlEntry::diffuse;
    if (keyword == "Ks") member = &MtlEntry::specular;
    if (keyword == "Ke") member = &MtlEntry::emission;
    if (keyword == "Tf") member = &MtlEntry::filter;
    if (!member) return false;
    MtlEntry& target = entry();
    if (in_.at_line_end()) throw in_.error("the line ends here", "three colour components");
    if (in_.peek() == 's' || in_.peek() == 'x') {
      add_warning(fmt::format("{} {} is not read", keyword, in_.word()));
      return true;
    }
    const float r = in_.number("a colour component");
    const auto g = in_.optional_number("a colour component");
    const auto b = in_.optional_number("a colour component");
    if (g && !b) throw in_.error("two colour components", "one or three");
    target.*member = MtlEntry::Rgb{r, g.value_or(r), b.value_or(r)};
    for (float& c : *(target.*member)) {
      if (c >= 0) continue;
      warnings_.repair(
          fmt::format("{}", c), "a component of 0 or more", "0 is taken",
          [&] { return in_.place(); }, keyword);
      c = 0;
    }
    return true;
  }

  /// The keyword's number, the nearest within the limits where it lies outside of them.
  float within(const std::string& keyword, const char* what, float least, float most) {
    const float value = in_.number(what), nearest = std::clamp(value, least, most);
    if (value != nearest) {
      warnings_.repair(
          in_.quoted_word(), what, fmt::format("{} is taken", nearest), [&] { return in_.place(); },
          keyword);
    }
    return nearest;
  }
  float share(const std::string& keyword) { return within(keyword, "a share of 0 to 1", 0, 1); }

  bool number(const std::string& keyword) {
    if (keyword == "d") {
      MtlEntry& target = entry();
      in_.at_line_end();
      if (in_.peek() == '-' && std::isalpha(static_cast<unsigned char>(in_.peek(1))))
        add_warning(fmt::format("d {} is read as plain d", in_.word()));
      target.numbers["d"] = share(keyword);
    } else if (keyword == "Tr" || keyword == "Pr" || keyword == "Pm" || keyword == "Pc" ||
               keyword == "Pcr") {
      entry().numbers[keyword] = share(keyword);
      if (keyword == "Tr") entry_.transparency_place = in_.place();
    } else if (keyword == "Ns") {
      entry().numbers["Ns"] =
          within(keyword, "an exponent of 0 or more", 0, std::numeric_limits<float>::max());
    } else if (keyword == "Ni") {
      const float index = in_.number("a refractive index");
      if (index > 0) {
        entry().numbers["Ni"] = index;
      } else {
        warnings_.repair(
            in_.quoted_word(), "a refractive index above 0", "it is left out",
            [&] { return in_.place(); }, keyword);
      }
    } else if (keyword == "illum") {
      const float model = in_.number("an illumination model of 0 to 10");
      const float whole = std::round(model);
      if (!(model >= 0 && model <= 10) || std::abs(model - whole) > kMtlRounding)
        throw in_.error(in_.quoted_word(), "an illumination model of 0 to 10");
      if (whole == 10)
        add_warning("illum 10: shadows that fall on something invisible are not read");
      entry().illumination = static_cast<int>(whole);
    } else {
      return false;
    }
    return true;
  }

  bool map(const std::string& keyword) {
    constexpr std::array<std::string_view, 13> kRead{
        "map_ka", "map_kd", "map_ks",  "map_ns",  "map_d",   "map_ke", "map_pr",
        "map_pm", "map_pc", "map_pcr", "map_orm", "map_rma", "bump"};
    const std::string statement = map_statement(keyword);
    if (statement.empty()) return false;
    MtlEntry& target = entry();
    if (statement != "norm" && std::find(kRead.begin(), kRead.end(), statement) == kRead.end()) {
      add_warning(fmt::format("texture ({}) is not read", keyword));
      return true;
    }
    MtlMap read = read_mtl_map(in_, keyword, warnings_);
    const auto file =
        find_picture_ ? find_picture_(read.file, target.name) : std::optional(read.file);
    if (!file) return true;
    read.file = *file;
    target.maps[statement] = std::move(read);
    return true;
  }

  void skip(const std::string& keyword) {
    constexpr std::array<std::string_view, 4> kPhysical{"Ps", "aniso", "anisor", "sharpness"};
    if (std::find(kPhysical.begin(), kPhysical.end(), keyword) != kPhysical.end())
      add_warning(fmt::format("parameter '{}' is not read", keyword));
    else if (std::any_of(keyword.begin(), keyword.end(),
                         [](char c) { return static_cast<unsigned char>(c) < 0x20; }))
      throw in_.error("binary data", "the text of an MTL file");
    else
      add_warning(fmt::format("unknown statement {} is left out", in_.quoted_word()));
  }

  LineReader& in_;
  const MtlPictureFinder& find_picture_;
  MtlLibrary& library_;
  Warnings& warnings_;
  MtlEntry entry_;  ///< without a name before the first newmtl
};

}  // namespace

void read_mtl(LineReader& reader, const MtlPictureFinder& find_picture, MtlLibrary& library,
              Warnings& warnings) {
  MtlReader(reader, find_picture, library, warnings).read();
}

}  // namespace tessera
