#include "scenes/formats/stl/stl_reader.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <optional>

#include "base/file.h"
#include "base/lower_case.h"
#include "base/plain_text.h"
#include "scenes/import/plain_material.h"
#include "scenes/import/token_reader.h"
#include "scenes/import/warnings.h"
#include "scenes/mesh/mesh_data.h"
#include "scenes/mesh/point_table.h"

namespace tessera {
namespace {

constexpr uint64_t kMaxBytes = uint64_t{1} << 40;
constexpr size_t kMaxTriangles = 0x7FFFFFFF / 3;
constexpr size_t kHeader = 80, kDataBegin = 84, kRecord = 50;

using Corners = std::array<std::array<float, 3>, 3>;

/// The first coordinate that is not finite; null: none.
const float* find_endless(const Corners& corners) {
  for (const auto& corner : corners)
    for (const float& c : corner)
      if (!std::isfinite(c)) return &c;
  return nullptr;
}

class StlMesh {
 public:
  explicit StlMesh(Warnings& warnings) : warnings_(warnings) {}

  void add(const Corners& corners) {
    if (find_endless(corners)) return;
    std::array<uint32_t, 3> t;
    for (size_t i = 0; i < 3; ++i) t[i] = points_.add(corners[i]);
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0])
      warnings_.add("triangles with two equal corners are left out");
    else
      triangles_.insert(triangles_.end(), t.begin(), t.end());
  }

  /// Warns of what breaks a rule, for which a triangle is left out.
  void leave_out(const std::string& found, const std::string& expected,
                 const Warnings::Where& where) {
    if (!problem_) problem_ = scene_error(where(), found, expected);
    warnings_.repair(found, expected, "the triangle is left out", where);
  }

  /// Throws where such triangles were all that there was.
  MeshData take() {
    if (problem_ && triangles_.empty()) throw *problem_;
    MeshData mesh;
    mesh.positions = points_.take();
    mesh.triangles = std::move(triangles_);
    return mesh;
  }

 private:
  Warnings& warnings_;
  PointTable points_;
  std::vector<uint32_t> triangles_;
  std::optional<Error> problem_;  ///< what is wrong with the first triangle that was left out
};

uint32_t announced_triangles(std::string_view bytes) {
  uint32_t count = 0;
  if (bytes.size() >= kDataBegin) std::memcpy(&count, bytes.data() + kHeader, sizeof count);
  return count;
}

/// Where the count of a binary file is, a text has bytes that fit its length by no chance.
bool is_text_length(std::string_view bytes) {
  return bytes.size() != kDataBegin + uint64_t{announced_triangles(bytes)} * kRecord;
}

bool says_solid(std::string_view bytes) {
  return lower_case(std::string(TokenReader(bytes, "").word())) == "solid";
}

/// Binary files may begin with "solid" too; a text has a facet where those have their first
/// triangles, and else no zero.
bool is_text(std::string_view bytes) {
  constexpr size_t kBegin = 1000;
  return says_solid(bytes) &&
         (lower_case(std::string(bytes.substr(0, kBegin))).find("facet normal") !=
              std::string::npos ||
          bytes.find('\0') == std::string_view::npos);
}

/// A binary file's header may be anything: this has to be a text's.
bool is_text_in_utf16(std::string_view bytes) {
  std::string head(bytes.substr(0, 40));
  std::erase_if(head, [](char c) { return c == '\0' || c == '\xFF' || c == '\xFE'; });
  return is_utf16(bytes) && says_solid(head);
}

/// Whether most of the first records from number `first` on hold a normal, or zeros for one: other
/// bytes than triangles have them by no chance.
bool are_triangles(std::string_view bytes, size_t first) {
  constexpr size_t kMost = 100;
  const std::string_view records = bytes.substr(kDataBegin + first * kRecord);
  const size_t looked_at = std::min(records.size() / kRecord, kMost);
  size_t normals = 0;
  for (size_t i = 0; i < looked_at; ++i) {
    std::array<float, 3> n;
    std::memcpy(n.data(), records.data() + i * kRecord, sizeof n);
    const double squared = double{n[0]} * n[0] + double{n[1]} * n[1] + double{n[2]} * n[2];
    if (squared == 0 || std::abs(squared - 1) < .01) ++normals;
  }
  return normals * 2 > looked_at;
}

/// How many triangles of a binary file are read: as many as it announces, or as it holds where that
/// is another number because the file was cut short, or its header never completed.
size_t triangles_to_read(std::string_view bytes, const std::string& name, Warnings& warnings) {
  const size_t announced = announced_triangles(bytes);
  const size_t held = (bytes.size() - kDataBegin) / kRecord;
  const bool is_filled = (bytes.size() - kDataBegin) % kRecord == 0;
  if (announced == held && is_filled) return announced;
  const bool has_more = announced < held && (is_filled || announced == 0);
  if (announced <= held && !(has_more && are_triangles(bytes, announced))) {
    warnings.add("what follows the last triangle is not read");
    return announced;
  }
  const std::string found = fmt::format(
      "{}{} triangles in the header",
      says_solid(bytes) ? "'solid', but zeros behind it as in binary files, and " : "", announced);
  const std::string expected = fmt::format("{}, which the file can hold", held);
  if (!are_triangles(bytes, 0)) throw scene_error({name}, found, expected);
  warnings.repair(found, expected, "those are read", [&] { return SourcePlace{name}; });
  return held;
}

void read_binary(std::string_view bytes, const std::string& name, StlMesh& mesh,
                 Warnings& warnings) {
  if (bytes.size() < kDataBegin)
    throw scene_error({name}, "neither 'solid' nor the 84 bytes that binary files begin with",
                      "an STL file");
  const size_t count = triangles_to_read(bytes, name, warnings);
  if (count > kMaxTriangles)
    throw scene_error({name}, fmt::format("{} triangles", count),
                      fmt::format("at most {}", kMaxTriangles));
  for (size_t i = 0; i < count; ++i) {
    Corners corners;
    std::memcpy(corners.data(), bytes.data() + kDataBegin + i * kRecord + 12, sizeof corners);
    if (const float* const c = find_endless(corners))
      mesh.leave_out(fmt::format("triangle {} of {}: coordinate {}", i + 1, count, *c),
                     "finite numbers", [&] { return SourcePlace{name}; });
    mesh.add(corners);
  }
}

class StlText {
 public:
  StlText(std::string_view bytes, const std::string& name, StlMesh& mesh)
      : bytes_(bytes), name_(name), in_(bytes, name), mesh_(mesh) {}

  void read() {
    for (;;) {
      const std::string keyword = next();
      if (keyword.empty()) return;
      if (keyword == "facet") {
        facet();
      } else if (keyword == "solid" || keyword == "endsolid" ||
                 (keyword == "end" && expect("solid"))) {
        skip_name();
      } else if (keyword != "end") {
        leave_out("facet, solid or endsolid");
      }
    }
  }

 private:
  /// Some programs write keywords in capitals.
  std::string next() { return lower_case(std::string(in_.word())); }

  bool expect(std::string_view wanted) {
    if (next() == wanted) return true;
    leave_out(fmt::format("'{}'", wanted));
    return false;
  }

  /// Warns of the word that was read last, and goes to where the next facet may begin.
  void leave_out(const std::string& expected) {
    mesh_.leave_out(in_.quoted_word(), expected, [&] { return in_.place(); });
    go_to(in_.word_offset());
    for (std::string word = next(); !word.empty() && word != "endfacet"; word = next())
      if (word == "facet" || word == "solid") return go_to(in_.word_offset());
  }

  /// To the end of the line, or to the facet that begins in it: some files are one line.
  void skip_name() {
    for (size_t before = in_.offset();; before = in_.offset()) {
      const std::string_view word = in_.word();
      const size_t begin = in_.offset() - word.size();
      const bool ends =
          bytes_.substr(before, begin - before).find_first_of("\r\n") != std::string_view::npos;
      if (ends) return go_to(before);
      if (word.empty()) return;
      if (lower_case(std::string(word)) != "facet") continue;
      const size_t behind = in_.offset();
      const bool is_facet = next() == "normal";
      go_to(is_facet ? begin : behind);
      if (is_facet) return;
    }
  }
  void go_to(size_t offset) { in_ = TokenReader(bytes_, name_, offset); }

  void facet() {
    if (!expect("normal")) return;
    // Never used, and some programs write what is no number for the normals of slivers.
    for (int a = 0; a < 3; ++a)
      if (in_.word().empty()) return leave_out("a component of the normal");
    if (!expect("outer") || !expect("loop")) return;
    Corners corners{};
    for (auto& corner : corners) {
      if (!expect("vertex")) return;
      for (float& c : corner) {
        c = static_cast<float>(in_.number());
        if (!std::isfinite(c)) return leave_out("a coordinate that single precision can hold");
      }
    }
    if (expect("endloop") && expect("endfacet")) mesh_.add(corners);
  }

  std::string_view bytes_;
  const std::string& name_;
  TokenReader in_;
  StlMesh& mesh_;
};

}  // namespace

LoadedScene parse_stl(std::string_view bytes, const std::string& name) {
  // A binary file's header may be anything.
  const std::string_view text = skip_byte_order_mark(bytes);
  LoadedScene out;
  Warnings warnings;
  StlMesh builder(warnings);
  if (is_text_length(bytes) && is_text_in_utf16(bytes)) refuse_wide_text(bytes, name);
  if (is_text(text) && is_text_length(bytes))
    StlText(text, name, builder).read();
  else
    read_binary(bytes, name, builder, warnings);
  MeshData mesh = builder.take();
  if (mesh.triangle_count() == 0) {
    warnings.add("no triangles: there is nothing to see");
  } else {
    v1::Node& node = *out.scene.add_nodes();
    node.set_name(to_utf8(std::filesystem::path(name).stem().string()));
    *out.scene.add_materials() = plain_material("default", false);
    node.mutable_shape()->add_materials("default");
    *node.mutable_shape()->mutable_mesh() = store_mesh(std::move(mesh), out.blobs);
  }
  warnings.add_to(out, name);
  return out;
}

LoadedScene read_stl(const std::string& path) {
  return parse_stl(read_input_file(path, kMaxBytes), path);
}

}  // namespace tessera
