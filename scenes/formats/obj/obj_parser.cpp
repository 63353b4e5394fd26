#include "scenes/formats/obj/obj_parser.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>

#include "base/file.h"
#include "base/plural.h"
#include "scenes/mesh/vertex_colors.h"

namespace tessera {
namespace {

/// Statements of the format that describe no polygon: curves, surfaces, display attributes.
constexpr std::array<std::string_view, 28> kNotPolygons{
    "vp",         "deg",       "bmat",  "step",     "cstype",   "curv",   "curv2",
    "surf",       "parm",      "trim",  "hole",     "scrv",     "sp",     "end",
    "con",        "bevel",     "lod",   "c_interp", "d_interp", "usemap", "maplib",
    "shadow_obj", "trace_obj", "ctech", "stech",    "mg",       "call",   "csh"};

bool is_text(std::string_view word) {
  return std::none_of(word.begin(), word.end(),
                      [](char c) { return static_cast<unsigned char>(c) < 0x20; });
}

}  // namespace

ObjFile ObjParser::parse() {
  while (in_.next_line()) {
    const std::string_view keyword = in_.word();
    if (keyword.empty() || keyword.front() == '#') continue;
    statement(keyword);
  }
  if (problem_ && file_.mesh.triangle_count() == 0) throw *problem_;
  if (unknown_statement_ && file_.mesh.positions.empty()) throw *unknown_statement_;
  return std::move(file_);
}

void ObjParser::repair(std::string_view found, std::string_view expected, std::string_view taken) {
  warnings_.repair(found, expected, taken, [&] { return in_.place(); });
}

void ObjParser::leave_out(std::string_view found, std::string_view expected,
                          std::string_view taken) {
  if (!problem_) problem_ = in_.error(found, expected);
  repair(found, expected, taken);
}

float ObjParser::finite(const char* what, float instead, std::string_view taken) {
  return checked(in_.any_number(), what, instead, taken);
}

float ObjParser::checked(float value, const char* what, float instead, std::string_view taken) {
  if (std::isfinite(value)) return value;
  repair(in_.quoted_word(), in_.rule(what, value), taken);
  return instead;
}

void ObjParser::statement(std::string_view keyword) {
  // What most lines are: a character costs less to compare than a text.
  if (keyword.size() == 1 && keyword.front() == 'v') return vertex();
  if (keyword.size() == 1 && keyword.front() == 'f') return face();
  if (keyword == "fo") return face();
  if (keyword == "vn") return normal();
  if (keyword == "vt") return texture_coordinate();
  if (keyword == "usemtl") return use_material();
  if (keyword == "s") return smoothing();
  if (keyword == "mtllib") {
    std::string name = in_.rest();
    file_.libraries.push_back({std::move(name), in_.place()});
    return;
  }
  if (keyword == "g" || keyword == "o") return;
  skip(keyword);
}

void ObjParser::skip(std::string_view keyword) {
  if (keyword == "l" || keyword == "p") {
    warnings_.add(keyword == "l" ? "lines (l) have no surface and are left out"
                                 : "points (p) have no surface and are left out");
  } else if (std::find(kNotPolygons.begin(), kNotPolygons.end(), keyword) != kNotPolygons.end()) {
    warnings_.add(fmt::format("statement '{}' describes no polygon and is left out", keyword));
  } else if (!is_text(keyword)) {
    leave_out("binary data", "the text of an OBJ file", "the line is left out");
  } else {
    const std::string word = in_.quoted_word();
    warnings_.add(fmt::format("unknown statement {} is left out", word));
    if (!unknown_statement_) {
      unknown_statement_ = in_.error(fmt::format("no vertex (v) in the whole file, but {}", word),
                                     "the text of an OBJ file");
    }
  }
}

void ObjParser::vertex() {
  std::vector<float>& positions = file_.mesh.positions;
  if (positions.size() / 3 >= ObjMesh::kMaxElements)
    throw in_.error("too many vertices", fmt::format("at most {}", ObjMesh::kMaxElements));
  constexpr const char* kCoordinate = "a coordinate";
  constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();
  for (int a = 0; a < 3; ++a) {
    const float value = in_.any_number();
    const bool is_placed = std::isfinite(value);
    if (!is_placed)
      leave_out(in_.quoted_word(), in_.rule(kCoordinate, value), "the faces there are left out");
    positions.push_back(is_placed ? value : kNowhere);
  }
  // Four numbers: a weight, which only curves use. Six or seven: a colour at the end.
  std::array<float, 4> more{};
  size_t count = 0;
  while (count < more.size()) {
    const auto value = in_.optional_any_number();
    if (!value) break;
    more[count++] = checked(*value, "a number", 1, "1 is taken");
  }
  std::vector<float>& colors = file_.mesh.colors;
  if (count >= 3) {
    colors.resize((positions.size() / 3 - 1) * 4, 1.f);
    for (size_t c = count - 3; c < count; ++c) {
      const float share = std::clamp(more[c], 0.f, 1.f);
      if (more[c] != share)
        repair(fmt::format("{} in a vertex's colour", more[c]), "a share of 0 to 1",
               fmt::format("{} is taken", share));
      colors.push_back(vertex_light(share, VertexColorSource::obj));
    }
    colors.push_back(1.f);
  } else if (!colors.empty()) {
    colors.resize(positions.size() / 3 * 4, 1.f);
  }
}

void ObjParser::texture_coordinate() {
  std::vector<float>& uvs = file_.mesh.uvs;
  if (uvs.size() / 2 >= ObjMesh::kMaxElements) throw in_.error("too many vt", "fewer");
  constexpr const char* kWhat = "a texture coordinate";
  for (int a = 0; a < 2; ++a)
    uvs.push_back(checked(in_.optional_any_number().value_or(0.f), kWhat, 0, "0 is taken"));
}

void ObjParser::normal() {
  std::vector<float>& normals = file_.mesh.normals;
  if (normals.size() / 3 >= ObjMesh::kMaxElements) throw in_.error("too many vn", "fewer");
  for (int a = 0; a < 3; ++a)
    normals.push_back(finite("a component of the normal", 0, "0 is taken"));
  const float* const n = &normals[normals.size() - 3];
  if (n[0] != 0 || n[1] != 0 || n[2] != 0) return;
  repair("a normal of no length", "a direction", "the faces there are as if it were not given");
}

void ObjParser::smoothing() {
  const std::string_view group = in_.word();
  smoothing_group_ = 0;
  if (group == "off" || group == "0") return;
  if (group == "on") {
    smoothing_group_ = 1;
    return;
  }
  const auto [stop, problem] =
      std::from_chars(group.data(), group.data() + group.size(), smoothing_group_);
  constexpr uint32_t kMostGroups = ObjMesh::kMostSmoothingGroups;
  if (stop != group.data() + group.size() || problem == std::errc::invalid_argument) {
    smoothing_group_ = 0;
    repair(in_.quoted_word(), "a smoothing group's number, 'on' or 'off'", "'off' is taken");
  } else if (problem != std::errc() || smoothing_group_ > kMostGroups) {
    smoothing_group_ = kMostGroups;
    repair(in_.quoted_word(), fmt::format("a smoothing group up to {}", kMostGroups),
           "that one is taken");
  }
}

void ObjParser::use_material() {
  const std::string name = to_utf8(in_.rest());
  if (name.empty()) repair("usemtl without a name", "a material's name", "grey is taken");
  const auto [at, is_new] =
      material_index_.try_emplace(name, static_cast<uint32_t>(file_.materials.size()));
  if (is_new) file_.materials.push_back({name, in_.place()});
  material_ = at->second;
}

uint32_t ObjParser::current_material() {
  if (material_ == kNoIndex) {
    material_ = static_cast<uint32_t>(file_.materials.size());
    file_.materials.emplace_back();
  }
  return material_;
}

uint32_t ObjParser::reference(const char* what, size_t count, std::string_view taken) {
  const std::optional<int64_t> written = in_.index();
  const int64_t number = written.value_or(0);
  const int64_t index = number < 0 ? static_cast<int64_t>(count) + number : number - 1;
  if (index >= 0 && index < static_cast<int64_t>(count)) return static_cast<uint32_t>(index);
  if (!written)
    leave_out(in_.quoted_word(), "a vertex index", taken);
  else if (number == 0)
    leave_out(fmt::format("{} 0 in {}", what, in_.quoted_word()),
              "a count from 1, or a negative one from the end", taken);
  else
    leave_out(fmt::format("a {} in {}, of {} so far", what, in_.quoted_word(), count),
              fmt::format("a {} before it", what), taken);
  return kNoIndex;
}

bool ObjParser::corner() {
  constexpr std::string_view kFace = "the face is left out", kPart = "the face is without it";
  const ObjMesh& mesh = file_.mesh;
  MeshCorner corner;
  corner.position = reference("vertex", mesh.position_count(), kFace);
  if (corner.position == kNoIndex) return false;
  if (in_.peek() == '/') {
    in_.skip_char();
    if (in_.peek() != '/' && !in_.at_word_end())
      corner.uv = reference("texture coordinate", mesh.uvs.size() / 2, kPart);
    if (in_.peek() == '/') {
      in_.skip_char();
      if (!in_.at_word_end()) {
        corner.normal = reference("normal", mesh.normals.size() / 3, kPart);
        if (corner.normal != kNoIndex) {
          const float* const n = &mesh.normals[size_t{corner.normal} * 3];
          if (n[0] == 0 && n[1] == 0 && n[2] == 0) corner.normal = kNoIndex;
        }
      }
    }
  }
  if (!in_.at_word_end()) {
    leave_out(in_.quoted_word(), "v, v/t, v//n or v/t/n", kFace);
    return false;
  }
  polygon_.push_back(corner);
  return true;
}

void ObjParser::face() {
  polygon_.clear();
  while (!in_.at_line_end() && in_.peek() != '#')
    if (!corner()) return;
  if (polygon_.size() < 3) {
    leave_out("a face with " + counted(polygon_.size(), "corner"), "at least 3", "it is left out");
    return;
  }
  if (problem_ && !is_placed()) return;
  // A face either brings all of its normals or gets them from its smoothing group.
  const bool complete = std::none_of(polygon_.begin(), polygon_.end(),
                                     [](const auto& c) { return c.normal == kNoIndex; });
  if (!complete) {
    const uint32_t generated =
        smoothing_group_ == 0 ? kNoIndex : ObjMesh::kFirstSmoothingGroup + (smoothing_group_ - 1);
    for (MeshCorner& c : polygon_) c.normal = generated;
  }
  add_polygon();
}

bool ObjParser::is_placed() const {
  return std::all_of(polygon_.begin(), polygon_.end(), [&](const MeshCorner& corner) {
    const float* const p = &file_.mesh.positions[size_t{corner.position} * 3];
    return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
  });
}

void ObjParser::add_polygon() {
  triples_.clear();
  if (polygon_.size() == 3) {
    triples_.push_back({0, 1, 2});
  } else {
    points_.clear();
    const std::vector<float>& p = file_.mesh.positions;
    for (const MeshCorner& c : polygon_) {
      const size_t at = size_t{c.position} * 3;
      points_.push_back({p[at], p[at + 1], p[at + 2]});
    }
    if (!triangulate(points_, triples_)) {
      leave_out(fmt::format("a concave face with {} corners", polygon_.size()),
                fmt::format("at most {}", kMaxConcaveCorners), "it is left out");
      return;
    }
  }
  if (file_.mesh.triangle_count() + triples_.size() > ObjMesh::kMaxElements)
    throw in_.error("too many faces", "fewer than 2^31 triangles");
  const uint32_t material = current_material();
  for (const CornerTriple& t : triples_) {
    const MeshCorner &a = polygon_[t[0]], &b = polygon_[t[1]], &c = polygon_[t[2]];
    if (a.position == b.position || b.position == c.position || c.position == a.position) {
      warnings_.add("triangles that name a vertex twice are left out");
      continue;
    }
    file_.mesh.add_triangle(a, b, c);
    // Kept only from the second material on: most files have one.
    if (material != 0 || !file_.mesh.face_materials.empty()) {
      file_.mesh.face_materials.resize(file_.mesh.triangle_count() - 1, 0);
      file_.mesh.face_materials.push_back(material);
    }
  }
}

}  // namespace tessera
