#include "scenes/formats/obj/obj_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "base/file.h"
#include "base/input_scope.h"
#include "renderer/math/bounds.h"
#include "scenes/formats/obj/line_reader.h"
#include "scenes/formats/obj/mtl_reader.h"
#include "scenes/formats/obj/obj_parser.h"
#include "scenes/import/picture_problem.h"
#include "scenes/import/plain_material.h"
#include "scenes/import/read_cache.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

bool is_there(const fs::path& file) {
  std::error_code ignored;
  return is_input_file(file) || fs::exists(file, ignored);
}

/// Whether it is a file that is not empty: an empty library is no error.
bool has_text(const fs::path& file) {
  std::error_code ignored;
  if (const auto text = InputScope::text_of(file)) return !text->empty();
  return fs::is_regular_file(file, ignored) && fs::file_size(file, ignored) > 0;
}

/// The files that the text after mtllib names: one whose name has spaces, or several.
std::vector<std::string> library_names(const std::string& written, const AssetFolder& assets) {
  const auto whole = assets.find(written);
  if (whole && is_there(*whole)) return {written};
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

/// A picture that an MTL file names, whose assets these are: what it is called from `folder`.
/// Without `check` it need only be there.
std::optional<std::string> find_picture(const std::string& written, const AssetFolder& assets,
                                        const fs::path& folder, const PictureCheck& check,
                                        const SourcePlace& place, Warnings& warnings) {
  const std::string problem = picture_problem(assets, written, check);
  if (problem.empty()) {
    const auto found = assets.find_asset(written);
    if (!found.note.empty())
      warnings.add(fmt::format("picture {}", found.note), [&] { return place; });
    return found.file->lexically_relative(folder).generic_string();
  }
  warnings.missing(fmt::format("picture '{}' {}", written, problem), [&] { return place; });
  return std::nullopt;
}

/// Of the materials named in `used` pictures are checked. `notes`: of the OBJ file.
void read_library(const ObjFile::Reference& written, const AssetFolder& assets,
                  const PictureCheck& check, const std::vector<ObjFile::Reference>& used,
                  MtlLibrary& library, LoadedScene& out, const std::string& path, Warnings& notes) {
  const auto place = [&] { return written.place; };
  std::string name = written.name;
  for (char& c : name)
    if (c == '\\') c = '/';
  const auto [file, note] = assets.find_asset(name);
  if (!note.empty()) notes.add(fmt::format("material library {}", to_utf8(note)), place);
  if (!file) {
    notes.missing(fmt::format("material library '{}' lies outside {} and is not read",
                              to_utf8(written.name), assets.shown_root(name)),
                  place);
  } else if (!is_there(*file)) {
    notes.missing(fmt::format("material library '{}' is not there", to_utf8(written.name)), place);
  } else if (has_text(*file)) {
    Warnings warnings;
    const bool is_as_written = !assets.searches_root && note.empty();
    LineReader reader(is_as_written ? (fs::path(path).parent_path() / name).string()
                                    : file->string());
    AssetFolder below = assets;
    below.folder = file->parent_path();
    const auto finder = [&](const std::string& picture, const std::string& material) {
      const bool is_used =
          std::ranges::find(used, material, &ObjFile::Reference::name) != used.end();
      return find_picture(picture, below, assets.folder, is_used ? check : PictureCheck{},
                          reader.place(), warnings);
    };
    read_mtl(reader, finder, library, warnings);
    warnings.add_to(out, reader.name());
  }
}

/// The length of the diagonal of the box around the positions.
double size_of(const std::vector<float>& positions) {
  Bounds3 box;
  for (size_t i = 0; i + 2 < positions.size(); i += 3)
    box.extend(Point3{positions[i], positions[i + 1], positions[i + 2]});
  return box.empty() ? 0 : length(box.diagonal());
}

/// What an OBJ file says by itself, whatever its libraries do.
struct ObjGeometry {
  std::vector<ObjFile::Reference> materials, libraries;  ///< as of ObjFile
  double size = 0;                                       ///< of size_of() its positions
  bool has_triangles = false, has_colors = false;
  v1::TriangleMesh mesh;
  BlobStore blobs;
  Warnings warnings;
};

ObjGeometry read_geometry(LineReader& reader) {
  ObjGeometry out;
  ObjFile file = ObjParser(reader, out.warnings).parse();
  out.materials = std::move(file.materials);
  out.libraries = std::move(file.libraries);
  out.has_triangles = file.mesh.triangle_count() > 0;
  if (!out.has_triangles) return out;
  out.size = size_of(file.mesh.positions);
  out.has_colors = !file.mesh.colors.empty();
  out.mesh = store_mesh(file.mesh.finish(), out.blobs);
  return out;
}

uint64_t bytes_of(const ObjGeometry& geometry) {
  uint64_t bytes = geometry.mesh.SpaceUsedLong();
  for (const auto& [digest, blob] : geometry.blobs.all()) bytes += blob->size();
  return bytes;
}

/// Puts the materials that the mesh uses into the scene, in the order of use, with their textures.
void add_materials(const ObjGeometry& file, const MtlLibrary& library, LoadedScene& out,
                   Warnings& warnings) {
  std::vector<std::string> known;
  for (const auto& entry : library.materials) known.push_back(entry.first);
  v1::Shape& shape = *out.scene.mutable_nodes(0)->mutable_shape();
  for (const auto& [name, place] : file.materials) {
    const auto found = library.materials.find(name);
    v1::Material& material = *out.scene.add_materials();
    if (found != library.materials.end()) {
      material = found->second;
      if (material.has_bump())
        material.mutable_bump()->set_value(material.bump().value() * 0.01 * file.size);
    } else {
      material = plain_material(name.empty() ? "default" : name, file.has_colors);
      if (!name.empty())
        warnings.missing(fmt::format("material '{}' is not defined; grey is taken{}", name,
                                     suggestion(name, known)),
                         [&where = place] { return where; });
    }
    shape.add_materials(material.name());
  }
  add_used_textures(library.textures, out.scene);
  out.picture_channels = library.picture_channels;
  for (const std::string& name : known)
    if (std::ranges::find(file.materials, name, &ObjFile::Reference::name) == file.materials.end())
      out.unused.push_back(fmt::format("material '{}'", name));
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

LoadedScene add_libraries(const ObjGeometry& file, const std::string& path,
                          const AssetFolder* assets, const PictureCheck& check) {
  LoadedScene out;
  Warnings warnings = file.warnings;
  MtlLibrary library;
  if (assets) {
    std::set<std::string> seen;
    for (const ObjFile::Reference& written : file.libraries)
      for (const std::string& name : library_names(written.name, *assets))
        if (seen.insert(name).second)
          read_library({name, written.place}, *assets, check, file.materials, library, out, path,
                       warnings);
  }
  if (!file.has_triangles) {
    warnings.add("no faces: there is nothing to see");
  } else {
    v1::Node& node = *out.scene.add_nodes();
    node.set_name(to_utf8(fs::path(path).stem().string()));
    add_materials(file, library, out, warnings);
    make_names_unique(out.scene);
    *node.mutable_shape()->mutable_mesh() = file.mesh;
    out.blobs = file.blobs;
  }
  warnings.add_to(out, path);
  return out;
}

}  // namespace

LoadedScene read_obj(const std::string& path, const ReadOptions& options) {
  const AssetFolder assets(path, options.assets);
  const auto file = remembered<ObjGeometry>(
      options.cache, fmt::format("obj|{}|{}", path, whole_path(path).string()),
      [&path] {
        LineReader reader(path);
        return read_geometry(reader);
      },
      bytes_of);
  return add_libraries(*file, path, &assets, options.check_picture);
}

LoadedScene parse_obj(std::string_view text, const std::string& name) {
  LineReader reader(text, name);
  return add_libraries(read_geometry(reader), name, nullptr, {});
}

}  // namespace tessera
