#include "studio/files/file_kind.h"

#include <algorithm>
#include <array>
#include <string>

#include "base/lower_case.h"

namespace tessera {
namespace {

constexpr std::array<std::string_view, 11> kScenes{
    "tessera", "tesserab", "json", "crt", "x3d", "x3dv", "wrl", "x3dz", "x3dvz", "wrz", "vrml"};
constexpr std::array<std::string_view, 6> kModels{"obj", "mtl", "ply", "stl", "gltf", "glb"};
constexpr std::array<std::string_view, 15> kPictures{"png", "jpg",  "jpeg", "exr",  "hdr",
                                                     "tif", "tiff", "bmp",  "tga",  "gif",
                                                     "ppm", "pgm",  "pfm",  "webp", "apng"};

template <size_t N>
bool has(const std::array<std::string_view, N>& endings, std::string_view ending) {
  return std::find(endings.begin(), endings.end(), ending) != endings.end();
}

}  // namespace

std::string_view name_of(FileKind kind) {
  switch (kind) {
    case FileKind::folder:
      return "folder";
    case FileKind::scene:
      return "scene";
    case FileKind::model:
      return "model";
    case FileKind::picture:
      break;
  }
  return "picture";
}

std::optional<FileKind> file_kind_of(std::string_view file_name) {
  std::string name = lower_case(std::string(file_name));
  if (name.ends_with(".gz")) name.resize(name.size() - 3);  // .x3d.gz, .wrl.gz
  const bool is_zipped = name.size() != file_name.size();
  const size_t dot = name.rfind('.');
  if (dot == std::string::npos) return std::nullopt;
  const std::string_view ending = std::string_view(name).substr(dot + 1);
  if (is_zipped) {
    const bool is_x3d = ending == "x3d" || ending == "x3dv" || ending == "wrl";
    return is_x3d ? std::optional(FileKind::scene) : std::nullopt;
  }
  if (has(kScenes, ending)) return FileKind::scene;
  if (has(kModels, ending)) return FileKind::model;
  if (has(kPictures, ending)) return FileKind::picture;
  return std::nullopt;
}

bool is_read_by_scenes(std::string_view file_name) {
  return file_kind_of(file_name) || lower_case(std::string(file_name)).ends_with(".bin");
}

}  // namespace tessera
