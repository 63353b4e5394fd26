#include "scenes/formats/obj/obj_reader.h"

#include <fmt/format.h>

#include <filesystem>
#include <set>

#include "base/file.h"
#include "scenes/formats/obj/line_reader.h"
#include "scenes/formats/obj/mtl_reader.h"
#include "scenes/formats/obj/obj_parser.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// The files that the text after mtllib names: one whose name has spaces, or several.
std::vector<std::string> library_names(const std::string& written, const fs::path& folder) {
  const auto whole = resolve_inside(folder, written);
  std::error_code ignored;
  if (whole && fs::exists(*whole, ignored)) return {written};
  // Some programs put a backslash before the spaces of a name.
  std::vector<std::string> names(1);
  for (size_t at = 0; at < written.size(); ++at) {
    const bool blank = written[at] == ' ' || written[at] == '\t';
    if (written[at] == '\\' && at + 1 < written.size() && written[at + 1] == ' ')
      names.back() += written[++at];
    else if (!blank)
      names.back() += written[at];
    else if (!names.back().empty())
      names.emplace_back();
  }
  if (names.back().empty()) names.pop_back();
  return names;
}

void read_library(const std::string& written, const fs::path& folder, MtlMaterials& materials,
                  LoadedScene& out, const std::string& path) {
  std::string name = written;
  for (char& c : name)
    if (c == '\\') c = '/';
  const auto file = resolve_inside(folder, name);
  std::error_code ignored;
  if (!file) {
    out.warnings.push_back(
        fmt::format("{}: material library '{}' lies outside the file's folder and is not read",
                    path, to_utf8(written)));
  } else if (!fs::exists(*file, ignored)) {
    out.warnings.push_back(
        fmt::format("{}: material library '{}' is not there", path, to_utf8(written)));
  } else if (fs::is_regular_file(*file, ignored) && fs::file_size(*file, ignored) > 0) {
    Warnings warnings;
    LineReader reader((folder / name).string());
    read_mtl(reader, materials, warnings);
    for (std::string& line : warnings.list(reader.name())) out.warnings.push_back(std::move(line));
  }
}

/// Puts the materials that the mesh uses into the scene, in the order of use.
void add_materials(const ObjFile& file, const MtlMaterials& materials, bool has_colors,
                   LoadedScene& out, Warnings& warnings) {
  std::vector<std::string> known;
  for (const auto& entry : materials) known.push_back(entry.first);
  v1::Shape& shape = *out.scene.mutable_nodes(0)->mutable_shape();
  for (const std::string& name : file.materials) {
    const auto found = materials.find(name);
    v1::Material& material = *out.scene.add_materials();
    if (found != materials.end()) {
      material = found->second;
    } else {
      material.set_name(name.empty() ? "default" : name);
      v1::Classic& classic = *material.mutable_classic();
      for (v1::ColorInput* input : {classic.mutable_ambient(), classic.mutable_diffuse()}) {
        v1::Color& grey = *input->mutable_value();
        grey.set_r(.8);
        grey.set_g(.8);
        grey.set_b(.8);
      }
      classic.set_vertex_color_replaces_diffuse(has_colors);
      if (!name.empty())
        warnings.add(fmt::format("material '{}' is not defined; grey is taken{}", name,
                                 suggestion(name, known)));
    }
    shape.add_materials(material.name());
  }
}

/// A material called "default" beside the one that we add under that name gets out of the way.
void make_names_unique(v1::Scene& scene) {
  std::set<std::string> taken;
  for (int i = 0; i < scene.materials_size(); ++i) {
    std::string name = scene.materials(i).name();
    while (!taken.insert(name).second) name += "'";
    scene.mutable_materials(i)->set_name(name);
    scene.mutable_nodes(0)->mutable_shape()->set_materials(i, name);
  }
}

LoadedScene read(LineReader& reader, const fs::path* folder) {
  LoadedScene out;
  Warnings warnings;
  ObjFile file = ObjParser(reader, warnings).parse();
  MtlMaterials materials;
  if (folder) {
    std::set<std::string> seen;
    for (const std::string& written : file.libraries)
      for (const std::string& name : library_names(written, *folder))
        if (seen.insert(name).second) read_library(name, *folder, materials, out, reader.name());
  }
  if (file.mesh.triangle_count() == 0) {
    if (file.mesh.positions.empty())
      throw scene_error({reader.name()}, "no vertex and no face", "the text of an OBJ file");
    warnings.add("no faces: there is nothing to see");
  } else {
    v1::Node& node = *out.scene.add_nodes();
    node.set_name(to_utf8(fs::path(reader.name()).stem().string()));
    add_materials(file, materials, !file.mesh.colors.empty(), out, warnings);
    make_names_unique(out.scene);
    *node.mutable_shape()->mutable_mesh() = store_mesh(file.mesh.finish(), out.blobs);
  }
  for (std::string& line : warnings.list(reader.name())) out.warnings.push_back(std::move(line));
  return out;
}

}  // namespace

LoadedScene read_obj(const std::string& path) {
  LineReader reader(path);
  const fs::path folder = fs::path(path).parent_path();
  return read(reader, &folder);
}

LoadedScene parse_obj(std::string_view text, const std::string& name) {
  LineReader reader(text, name);
  return read(reader, nullptr);
}

}  // namespace tessera
