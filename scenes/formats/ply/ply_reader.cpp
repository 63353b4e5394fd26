#include "scenes/formats/ply/ply_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <utility>

#include "base/file.h"
#include "base/plain_text.h"
#include "renderer/math/bounds.h"
#include "scenes/formats/ply/ply_source.h"
#include "scenes/import/picture_problem.h"
#include "scenes/import/plain_material.h"
#include "scenes/import/warnings.h"
#include "scenes/mesh/mesh_data.h"
#include "scenes/mesh/pen.h"
#include "scenes/mesh/triangulate.h"
#include "scenes/mesh/vertex_colors.h"

namespace tessera {
namespace {

constexpr uint64_t kMaxBytes = uint64_t{1} << 40;
constexpr uint64_t kMaxVertices = 0x7FFFFFFF;
constexpr size_t kMaxDrawnPoints = size_t{1} << 22;

/// What a vertex's properties mean: places in a row of numbers.
enum Slot : size_t { kX, kY, kZ, kNx, kNy, kNz, kU, kV, kRed, kGreen, kBlue, kAlpha, kSlots };
constexpr size_t kNone = kSlots;

size_t slot_of(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, Slot>, 25> kNames{{{"x", kX},
                                                                      {"y", kY},
                                                                      {"z", kZ},
                                                                      {"nx", kNx},
                                                                      {"ny", kNy},
                                                                      {"nz", kNz},
                                                                      {"u", kU},
                                                                      {"v", kV},
                                                                      {"s", kU},
                                                                      {"t", kV},
                                                                      {"texture_u", kU},
                                                                      {"texture_v", kV},
                                                                      {"texture_s", kU},
                                                                      {"texture_t", kV},
                                                                      {"red", kRed},
                                                                      {"green", kGreen},
                                                                      {"blue", kBlue},
                                                                      {"alpha", kAlpha},
                                                                      {"r", kRed},
                                                                      {"g", kGreen},
                                                                      {"b", kBlue},
                                                                      {"a", kAlpha},
                                                                      {"diffuse_red", kRed},
                                                                      {"diffuse_green", kGreen},
                                                                      {"diffuse_blue", kBlue}}};
  for (const auto& [known, slot] : kNames)
    if (name == known) return slot;
  return kNone;
}

/// What stands for all of a channel. Programs that write colours as wider or signed integers mean
/// codes of 8 bits all the same.
double all_of_channel(PlyType type) {
  return type >= PlyType::float32 ? 1 : type == PlyType::uint16 ? 65535 : 255;
}

float color_value(double share, PlyType type, bool is_alpha) {
  if (is_alpha) return static_cast<float>(share);
  return vertex_light(share, type >= PlyType::float32 ? VertexColorSource::ply_float
                                                      : VertexColorSource::ply_integer);
}

bool has_faces(const PlyElement& element) {
  return element.name == "face" || element.name == "tristrips";
}

/// Whether there is any; else the vertices themselves are what is seen.
bool has_faces(const PlyHeader& header) {
  return std::any_of(header.elements.begin(), header.elements.end(),
                     [](const PlyElement& e) { return e.count > 0 && has_faces(e); });
}

template <typename Source>
class PlyMesh {
 public:
  PlyMesh(Source source, Warnings& warnings) : in_(std::move(source)), warnings_(warnings) {}

  MeshData read(const PlyHeader& header) {
    is_cloud_ = !has_faces(header);
    for (size_t i = 0; i <= 255; ++i)
      codes_[i] = color_value(static_cast<double>(i) / 255, PlyType::uint8, false);
    std::vector<std::pair<const PlyElement*, Source>> before_vertices;
    bool is_whole = true;
    for (const PlyElement& element : header.elements) {
      if (element.properties.empty()) continue;
      if (has_faces(element) && mesh_.vertex_count() == 0)
        before_vertices.emplace_back(&element, in_);
      is_whole = attempt([&] {
        if (element.name == "vertex")
          vertices(element);
        else if (has_faces(element) && mesh_.vertex_count() > 0)
          faces(element);
        else
          leave_out(element);
      });
      if (!is_whole) break;
    }
    if (is_whole && in_.has_more())
      warnings_.add("what follows the last element is not read" + in_.announced());
    for (const auto& [element, begin] : before_vertices) {
      in_ = begin;
      attempt([&, from = element] { faces(*from); });
    }
    replace_endless(mesh_.normals, 3, 0);
    replace_endless(mesh_.uvs, 2, 0);
    replace_endless(mesh_.colors, 4, 1);
    if (is_cloud_)
      draw_cloud();
    else if (problem_)
      drop_unplaced(mesh_);
    if (problem_ && mesh_.triangle_count() == 0) throw *problem_;
    return std::move(mesh_);
  }

 private:
  /// Draws the vertices themselves, as wide as a view asks for that is framed for them.
  void draw_cloud() {
    const size_t count = mesh_.vertex_count();
    const size_t step = (count + kMaxDrawnPoints - 1) / kMaxDrawnPoints;
    if (step > 1)
      warnings_.add(fmt::format("of {} points one in {} is drawn; expected at most {}", count, step,
                                kMaxDrawnPoints));
    Bounds3 box;
    std::vector<uint32_t> points;
    for (size_t i = 0; i < count; i += step) {
      const float* const p = &mesh_.positions[i * 3];
      const Point3 at{p[0], p[1], p[2]};
      if (!is_finite(at - Point3{})) continue;
      box.extend(at);
      points.push_back(static_cast<uint32_t>(i));
    }
    v1::Camera view;
    view.set_frame_all(true);
    mesh_ = draw_strokes(Pen::for_view(view, {}, Pen::extent_of(box)), mesh_, points, 1);
  }

  /// Reads an element. Where the file cannot be followed any more, as where it was cut short, it
  /// warns that only what is whole before that is read, and returns false.
  template <typename Read>
  bool attempt(const Read& read) {
    try {
      read();
      return true;
    } catch (const Error& error) {
      if (!problem_) problem_ = error;
      warnings_.repair(error, "what is whole before it is read");
      return false;
    }
  }

  Error error(std::string_view row, std::string_view found, std::string_view expected) const {
    return scene_error(in_.place(), in_.told(row, found), expected);
  }

  /// Warns of what breaks a rule, for which faces are left out.
  void repair(std::string_view row, std::string_view found, std::string_view expected,
              std::string_view taken) {
    if (!problem_) problem_ = error(row, found, expected);
    warnings_.repair(in_.told(row, found), expected, taken, [&] { return in_.place(); });
  }

  void leave_out(const PlyElement& element) {
    if (element.count > 0 && !has_faces(element))
      warnings_.add(fmt::format("element '{}' is left out", element.name), element.count);
    skip(element);
  }

  template <typename Read>
  void for_each_row(const PlyElement& element, const Read& read) {
    for (row_ = 0; row_ < element.count; ++row_) {
      in_.begin_row();
      read();
      if (in_.has_more_in_row()) {
        warnings_.repair(in_.shown(0), fmt::format("the end of a row of '{}'", element.name),
                         "what is left of the line is not read", [&] { return in_.place(); });
      }
      in_.end_row();
    }
  }

  void skip(const PlyElement& element) {
    for_each_row(element, [&] {
      for (const PlyProperty& property : element.properties) skip(property);
    });
  }

  void skip(const PlyProperty& property) {
    const uint64_t count = property.count_type ? list_count(property) : 1;
    for (uint64_t i = 0; i < count; ++i) in_.skip(property.type);
  }

  uint64_t list_count(const PlyProperty& list) {
    const double count = in_.value(*list.count_type);
    const uint64_t most = in_.most_values(list.type);
    if (count >= 0 && count <= static_cast<double>(most) && count == std::floor(count))
      return static_cast<uint64_t>(count);
    const std::string row = fmt::format("a list '{}' of ", list.name), found = in_.shown(count);
    if (!in_.has_row_ends())
      throw error(row, found, fmt::format("a count of at most {}, which the file can hold", most));
    repair(row, found, "the number of values that follow in the line", "the line is left out");
    in_.skip_row();
    return 0;
  }

  void vertices(const PlyElement& element) {
    if (mesh_.vertex_count() > 0) throw error("", "a second element 'vertex'", "one");
    if (element.count > kMaxVertices)
      throw error("", "too many vertices", fmt::format("at most {}", kMaxVertices));
    std::vector<size_t> slots;
    std::array<bool, kSlots> has{};
    for (const PlyProperty& property : element.properties) {
      size_t slot = property.count_type ? kNone : slot_of(property.name);
      if (slot != kNone && has[slot]) slot = kNone;
      slots.push_back(slot);
      if (slot != kNone)
        has[slot] = true;
      else
        warnings_.add(fmt::format("property '{}' of 'vertex' is not read", property.name));
    }
    if (!has[kX] || !has[kY] || !has[kZ])
      throw error("", "vertices without x, y and z", "three coordinates");
    const bool normals = has[kNx] && has[kNy] && has[kNz];
    const bool uvs = has[kU] && has[kV];
    const bool colors = has[kRed] && has[kGreen] && has[kBlue];
    for_each_row(element, [&] {
      std::array<float, kSlots> values{};
      values[kAlpha] = 1;
      vertex(element, slots, values);
      const auto put = [&](std::vector<float>& to, size_t first, size_t last) {
        to.insert(to.end(), values.begin() + first, values.begin() + last + 1);
      };
      put(mesh_.positions, kX, kZ);
      if (normals) put(mesh_.normals, kNx, kNz);
      if (uvs) put(mesh_.uvs, kU, kV);
      if (colors) put(mesh_.colors, kRed, kAlpha);
    });
  }

  void say_endless(size_t slot, double value) {
    constexpr const char* kExpected = "a finite number that single precision can hold";
    const bool is_position = slot <= kZ;
    const std::string found = in_.told("", in_.shown(value));
    if (is_position && !problem_) problem_ = scene_error(in_.place(), found, kExpected);
    warnings_.repair(found, kExpected,
                     is_position
                         ? is_cloud_ ? "the point is left out" : "the faces there are left out"
                     : slot <= kNz ? "the face's own normal is taken"
                     : slot <= kV  ? "0 is taken"
                                   : "white is taken",
                     [&] { return in_.place(); });
  }

  double share(double value, PlyType type) {
    const double all = all_of_channel(type), nearest = std::clamp(value, 0.0, all);
    if (value != nearest)
      warnings_.repair(in_.told("", in_.shown(value)), fmt::format("a colour of 0 to {}", all),
                       fmt::format("{} is taken", nearest), [&] { return in_.place(); });
    return nearest / all;
  }

  void vertex(const PlyElement& element, const std::vector<size_t>& slots,
              std::array<float, kSlots>& values) {
    for (size_t p = 0; p < slots.size(); ++p) {
      const PlyProperty& property = element.properties[p];
      const size_t slot = slots[p];
      if (slot == kNone) {
        skip(property);
        continue;
      }
      const double value = in_.value(property.type);
      if (!(std::abs(value) <= std::numeric_limits<float>::max())) {
        say_endless(slot, value);
        values[slot] = std::numeric_limits<float>::quiet_NaN();
        continue;
      }
      if (slot < kRed)
        values[slot] = static_cast<float>(value);
      else if (slot < kAlpha && property.type == PlyType::uint8 && value >= 0 && value <= 255)
        values[slot] = codes_[static_cast<size_t>(value)];
      else
        values[slot] = color_value(share(value, property.type), property.type, slot == kAlpha);
    }
  }

  void faces(const PlyElement& element) {
    const bool strips = element.name == "tristrips";
    size_t list = element.properties.size();
    for (size_t p = 0; p < element.properties.size(); ++p) {
      const PlyProperty& property = element.properties[p];
      if (property.count_type &&
          (property.name == "vertex_indices" || property.name == "vertex_index"))
        list = p;
      else
        warnings_.add(
            fmt::format("property '{}' of '{}' is not read", property.name, element.name));
    }
    if (list == element.properties.size())
      throw error("", fmt::format("'{}' without vertex_indices", element.name),
                  "a list of that name");
    for_each_row(element, [&] {
      for (size_t p = 0; p < element.properties.size(); ++p) {
        if (p != list)
          skip(element.properties[p]);
        else if (strips)
          strip(element.properties[p]);
        else
          face(element.properties[p]);
      }
    });
  }

  /// Adds a corner to polygon_. False where there is no such vertex.
  bool corner(const PlyProperty& list, double value, std::string_view taken) {
    const size_t count = mesh_.vertex_count();
    if (value >= 0 && value < static_cast<double>(count) && value == std::floor(value)) {
      polygon_.push_back(static_cast<uint32_t>(value));
      return true;
    }
    repair(fmt::format("face {}: '{}' ", row_ + 1, list.name), in_.shown(value),
           count == 0 ? std::string("a file with vertices")
                      : fmt::format("an index of 0 to {}", count - 1),
           taken);
    return false;
  }

  void add(uint32_t a, uint32_t b, uint32_t c) {
    if (a == b || b == c || c == a)
      warnings_.add("triangles that name a vertex twice are left out");
    else
      mesh_.triangles.insert(mesh_.triangles.end(), {a, b, c});
  }

  void face(const PlyProperty& list) {
    const uint64_t count = list_count(list);
    polygon_.clear();
    bool is_whole = true;
    for (uint64_t i = 0; i < count; ++i)
      is_whole &= corner(list, in_.value(list.type), "the face is left out");
    if (!is_whole) return;
    if (count == 3) return add(polygon_[0], polygon_[1], polygon_[2]);
    if (count < 3) {
      return warnings_.add("faces with fewer than 3 corners are left out",
                           [&] { return in_.place(); });
    }
    points_.clear();
    for (const uint32_t v : polygon_) {
      const float* const p = &mesh_.positions[size_t{v} * 3];
      points_.push_back({p[0], p[1], p[2]});
    }
    triples_.clear();
    const auto is_placed = [](const Vec3& p) { return is_finite(p); };
    if (problem_ && !std::all_of(points_.begin(), points_.end(), is_placed)) return;
    if (!triangulate(points_, triples_)) {
      repair(fmt::format("face {}: ", row_ + 1), fmt::format("concave, with {} corners", count),
             fmt::format("at most {}", kMaxConcaveCorners), "it is left out");
      return;
    }
    for (const CornerTriple& t : triples_) add(polygon_[t[0]], polygon_[t[1]], polygon_[t[2]]);
  }

  /// Every index after the second makes a triangle with the two before it; -1 begins anew.
  void strip(const PlyProperty& list) {
    const uint64_t count = list_count(list);
    polygon_.clear();
    for (uint64_t i = 0; i < count; ++i) {
      const double value = in_.value(list.type);
      if (value == -1 || !corner(list, value, "the triangles there are left out")) {
        polygon_.clear();
        continue;
      }
      const size_t n = polygon_.size();
      if (n < 3) continue;
      const bool odd = n % 2 == 0;
      const uint32_t a = polygon_[n - 3], b = polygon_[n - 2], c = polygon_[n - 1];
      if (a != b && b != c && c != a) odd ? add(b, a, c) : add(a, b, c);
    }
  }

  Source in_;
  Warnings& warnings_;
  MeshData mesh_;
  bool is_cloud_ = false;  ///< it has no faces at all
  uint64_t row_ = 0;
  std::optional<Error> problem_;  ///< what is wrong with the first part that was left out
  std::array<float, 256> codes_{};
  std::vector<uint32_t> polygon_;
  std::vector<Vec3> points_;
  std::vector<CornerTriple> triples_;
};

MeshData read_mesh(const PlyHeader& header, std::string_view bytes, const std::string& name,
                   Warnings& warnings) {
  static_assert(std::endian::native == std::endian::little);
  switch (header.encoding) {
    case PlyHeader::Encoding::ascii:
      return PlyMesh(PlyText(bytes, name, header), warnings).read(header);
    case PlyHeader::Encoding::little_endian:
      return PlyMesh(PlyBinary<false>(bytes, name, header.data_begin), warnings).read(header);
    case PlyHeader::Encoding::big_endian:
      break;
  }
  return PlyMesh(PlyBinary<true>(bytes, name, header.data_begin), warnings).read(header);
}

/// Shows the picture in place of grey.
void add_texture(const std::string& file, v1::Scene& scene, v1::Material& material) {
  v1::Texture& texture = *scene.add_textures();
  texture.set_name(file);
  texture.mutable_image()->set_file(file);
  material.set_alpha(v1::Material::ALPHA_OPAQUE);
  v1::Classic& classic = *material.mutable_classic();
  for (v1::ColorInput* input : {classic.mutable_ambient(), classic.mutable_diffuse()}) {
    input->clear_value();
    input->set_texture(file);
  }
}

}  // namespace

LoadedScene parse_ply(std::string_view bytes, const std::string& name, const PictureCheck& check) {
  refuse_wide_text(bytes, name);  // the header is a text whatever follows it
  bytes = skip_byte_order_mark(bytes);
  LoadedScene out;
  Warnings warnings;
  const PlyHeader header = read_ply_header(bytes, name, warnings);
  const bool is_cloud = !has_faces(header);
  MeshData mesh = read_mesh(header, bytes, name, warnings);
  if (mesh.triangle_count() == 0) {
    warnings.add("no faces: there is nothing to see");
  } else {
    v1::Node& node = *out.scene.add_nodes();
    if (is_cloud) node.set_casts_no_shadow(true);
    node.set_name(to_utf8(std::filesystem::path(name).stem().string()));
    v1::Material& material = *out.scene.add_materials();
    material = plain_material("default", !mesh.colors.empty());
    if (const std::string& file = header.texture_file; !file.empty()) {
      const std::string problem = mesh.uvs.empty()
                                      ? "is left out, for vertices have no texture coordinates"
                                  : check ? check(file, nullptr)
                                          : "";
      if (problem.empty())
        add_texture(file, out.scene, material);
      else
        warnings.missing(fmt::format("picture '{}' {}", file, problem),
                         [&] { return header.texture_place; });
    }
    node.mutable_shape()->add_materials("default");
    *node.mutable_shape()->mutable_mesh() = store_mesh(std::move(mesh), out.blobs);
  }
  warnings.add_to(out, name);
  return out;
}

LoadedScene read_ply(const std::string& path, const ReadOptions& options) {
  const AssetFolder assets(path, options.assets);
  return parse_ply(read_input_file(path, kMaxBytes), path,
                   [&](const std::string& name, const std::string* /*bytes*/) {
                     return picture_problem(assets, name, options.check_picture);
                   });
}

}  // namespace tessera
