#include "scenes/formats/read_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>

#include "base/all_failures.h"
#include "base/error.h"
#include "base/file.h"
#include "base/lower_case.h"
#include "base/open_input.h"
#include "proto/wire/scene_codec.h"
#include "scenes/formats/crt/crt_reader.h"
#include "scenes/formats/default_view.h"
#include "scenes/formats/gltf/gltf_reader.h"
#include "scenes/formats/include_resolver.h"
#include "scenes/formats/obj/obj_reader.h"
#include "scenes/formats/ply/ply_reader.h"
#include "scenes/formats/stl/stl_reader.h"
#include "scenes/formats/x3d/x3d_reader.h"
#include "scenes/import/checked_pictures.h"
#include "scenes/import/read_cache.h"
#include "scenes/import/standard_view.h"
#include "scenes/import/texture_loader.h"
#include "scenes/import/warnings.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 12> kFormats{
    "tessera", "tesserab", "json", "obj", "ply", "stl", "gltf", "glb", "x3d", "x3dv", "wrl", "crt"};
/// Other endings of X3D's files, gzipped or old.
constexpr std::array<std::string_view, 5> kX3dToo{"gz", "x3dz", "x3dvz", "wrz", "vrml"};
/// Models: they may come without a camera and without light.
constexpr std::array<std::string_view, 5> kModels{"obj", "ply", "stl", "gltf", "glb"};
/// Formats that users may well try, so that the error can say that they were recognised.
constexpr std::array<std::string_view, 20> kOthers{
    "fbx", "dae", "blend", "3ds", "usd", "usda", "usdc", "usdz", "abc", "pbrt",
    "mtl", "xml", "pov",   "rib", "3mf", "off",  "lwo",  "c4d",  "ma",  "mb"};

/// Files that are what a scene is rendered to, and given for it by mistake.
constexpr std::array<std::string_view, 26> kPictures{
    "png", "apng", "jpg",  "jpeg", "exr",  "hdr",  "tif", "tiff", "tga",
    "bmp", "gif",  "webp", "ppm",  "pgm",  "pbm",  "pnm", "pfm",  "sgi",
    "rgb", "ico",  "psd",  "dds",  "heic", "avif", "jp2", "j2k"};

std::string readable() { return fmt::format("one of .{}", fmt::join(kFormats, ", .")); }

std::string head_of(const std::string& path) {
  constexpr size_t kEnough = 4096;
  check_input_file(path, UINT64_MAX);
  if (const auto text = InputScope::text_of(path)) return text->substr(0, kEnough);
  const InputFile file = open_input_file(path);
  if (!file) throw scene_error(fmt::format("{}: cannot be opened", path));
  std::string head(kEnough, '\0');
  head.resize(std::fread(head.data(), 1, head.size(), file.get()));
  return head;
}

/// For files whose ending says nothing.
std::string format_by_content(const std::string& path) {
  const std::string bytes = head_of(path);
  const std::string_view head = skip_byte_order_mark(bytes);
  if (head.starts_with("# proto-file: proto/tessera/v1/")) return "tessera";
  if (head.starts_with("ply\n") || head.starts_with("ply\r")) return "ply";
  if (lower_case(std::string(head.substr(0, 6))) == "solid ") return "stl";
  if (head.starts_with("glTF")) return "glb";
  if (head.starts_with("#X3D") || head.starts_with("#VRML") ||
      head.find("<X3D") != std::string::npos) {
    return "x3d";
  }
  if (head.starts_with('{')) return head.find("\"asset\"") != head.npos ? "gltf" : "json";
  return "";
}

std::string format_of(const std::string& path, const std::string& asked) {
  if (!asked.empty()) {
    if (std::find(kFormats.begin(), kFormats.end(), asked) != kFormats.end()) return asked;
    const std::vector<std::string> names(kFormats.begin(), kFormats.end());
    throw usage_error(fmt::format("unknown format '{}'; expected one of {}{}", asked,
                                  fmt::join(kFormats, ", "), suggestion(asked, names)));
  }
  std::string ending = lower_case(fs::path(path).extension().string());
  if (!ending.empty()) ending.erase(0, 1);
  if (std::find(kFormats.begin(), kFormats.end(), ending) != kFormats.end()) return ending;
  if (std::find(kX3dToo.begin(), kX3dToo.end(), ending) != kX3dToo.end()) return "x3d";
  check_input_file(path, UINT64_MAX);
  if (std::find(kPictures.begin(), kPictures.end(), ending) != kPictures.end())
    throw scene_error({path}, "a picture, which is no scene", readable());
  if (std::find(kOthers.begin(), kOthers.end(), ending) != kOthers.end())
    throw scene_error({path}, fmt::format("files of type .{} are not read", ending), readable());
  const std::string found = format_by_content(path);
  if (found.empty())
    throw scene_error({path},
                      ending.empty() ? std::string("the name has no ending")
                                     : fmt::format("unknown ending '.{}'", ending),
                      readable() + ", or a format that is asked for, as by --format");
  return found;
}

/// How a file of that format holds a scene of our own; nothing for what is imported.
std::optional<SceneEncoding> own_encoding(const std::string& format) {
  if (format == "tessera") return SceneEncoding::text;
  if (format == "tesserab") return SceneEncoding::binary;
  if (format == "json") return SceneEncoding::json;
  return std::nullopt;
}

LoadedScene read_format(const std::string& path, const std::string& format,
                        const ReadOptions& options) {
  if (format == "obj") return read_obj(path, options);
  if (format == "ply") return read_ply(path, options);
  if (format == "stl") return read_stl(path);
  if (format == "gltf" || format == "glb") return read_gltf(path, options);
  if (format == "x3d" || format == "x3dv" || format == "wrl") return read_x3d(path, options);
  if (format == "crt") return read_crt(path, options);
  // The blobs beside a file that is outside of the assets are as much outside as it is.
  const fs::path own = AssetFolder(path).root;
  const AssetFolder assets(path, options.assets);
  SceneWithBlobs read =
      read_scene_file(path, *own_encoding(format), assets.folder == own ? assets.root : own);
  LoadedScene loaded;
  loaded.scene = std::move(read.scene);
  loaded.blobs = std::move(read.blobs);
  return loaded;
}

/// All that what is read depends on beside files.
std::string key_of(const std::string& path, const std::string& format, const ReadOptions& options) {
  return fmt::format("scene|{}|{}|{}|{}|{}|{}|{}|{}|{}|{}|{}|{}|{}|{}", format,
                     static_cast<int>(options.x3d_color), static_cast<int>(options.x3d_shadows),
                     static_cast<int>(options.x3d_texture), options.x3d_weld, options.x3d_strict,
                     options.two_sided, options.origins, options.decode_texture != nullptr,
                     options.decode_texture_bytes != nullptr, options.frame, options.assets, path,
                     whole_path(path).string());
}

uint64_t bytes_of(const LoadedScene& loaded) {
  uint64_t bytes = loaded.scene.SpaceUsedLong();
  for (const auto& [digest, blob] : loaded.blobs.all()) bytes += blob->size();
  for (const auto& [name, picture] : loaded.pictures) bytes += picture.size();
  return bytes;
}

/// With its pictures, without its includes.
LoadedScene read_one(const std::string& path, const std::string& asked,
                     const ReadOptions& options) {
  CheckedPictures pictures(options);
  const ReadOptions reading = pictures.reading();
  const std::string format = format_of(path, asked);
  const auto read = [&] {
    LoadedScene made = read_format(path, format, reading);
    if (options.origins)
      made.origins.add_missing(made.scene, path, own_encoding(format).has_value());
    return made;
  };
  LoadedScene loaded = !options.cache ? read()
                                      : *options.cache->get<LoadedScene>(
                                            key_of(path, format, options), read, bytes_of);
  load_textures(loaded, AssetFolder(path, options.assets), reading);
  return loaded;
}

/// Reads the files of one scene. What was only checked is kept until it is asked for.
class FileReader {
 public:
  /// `first` is the scene's own file.
  FileReader(const std::string& first, ReadOptions options)
      : options_(std::move(options)), assets_(first, options_.assets) {
    if (options_.strict) options_.x3d_strict = true;
    options_.check_scene = [this](const std::string& file) { return problem(file, ""); };
  }
  FileReader(const FileReader&) = delete;
  FileReader& operator=(const FileReader&) = delete;

  LoadedScene operator()(const std::string& file, const std::string& format) {
    const auto known = checked_.find({file, format});
    return known == checked_.end() ? read(file, format)
                                   : std::move(checked_.extract(known).mapped());
  }

 private:
  using Key = std::pair<std::string, std::string>;  ///< file and format

  LoadedScene read(const std::string& file, const std::string& format) {
    open_.push_back(whole_path(file));
    LoadedScene loaded = read_one(file, format, options_);
    open_.pop_back();
    return loaded;
  }

  /// Why the file, or one that it includes, cannot be read; empty where all can. Those that include
  /// themselves, or are too many, are for the resolver to find.
  std::string problem(const std::string& file, const std::string& format) {
    const bool is_open = std::find(open_.begin(), open_.end(), file) != open_.end();
    if (is_open || open_.size() > IncludeResolver::kMaxDepth) return "";
    const auto [at, is_new] = problems_.try_emplace({file, format});
    InputStates& looked_at = looked_at_[{file, format}];
    if (!is_new) {
      InputScope::note(looked_at);
      return at->second;
    }
    const InputScope scope(nullptr, &looked_at);
    const auto open = open_;
    try {
      LoadedScene loaded = read(file, format);
      open_.push_back(file);
      for (const v1::Include& include : loaded.scene.includes()) {
        const std::string inner = included_file(assets_, file, include).file->string();
        if (std::string why = problem(inner, include.format()); !why.empty()) {
          at->second = std::move(why);
          break;
        }
      }
      if (at->second.empty()) checked_.insert_or_assign({file, format}, std::move(loaded));
    } catch (const Error& error) {
      if (error.code() != ExitCode::bad_scene) throw;
      at->second = error.what();
    }
    open_ = open;
    return at->second;
  }

  ReadOptions options_;
  AssetFolder assets_;
  std::vector<fs::path> open_;  ///< being read, outermost first
  std::map<Key, std::string> problems_;
  std::map<Key, InputStates> looked_at_;  ///< to find those
  std::map<Key, LoadedScene> checked_;
};

/// Moves all that stands in the scene, under one node.
void place_itself(v1::Scene& scene, const v1::Transform& transform) {
  v1::Node whole;
  *whole.mutable_transform() = transform;
  whole.mutable_children()->Swap(scene.mutable_nodes());
  *scene.add_nodes() = std::move(whole);
}

/// Takes into the scene of `path` what it includes, and what is to be placed beside.
void add_others(const std::string& path, const ReadOptions& options, FileReader& read,
                LoadedScene& loaded) {
  ReadOptions without_assets = options;
  without_assets.assets.clear();
  const IncludeResolver::Reader read_whole = [&](const std::string& file,
                                                 const std::string& format) {
    FileReader read_placed(file, without_assets);
    LoadedScene whole = read_placed(file, format);
    IncludeResolver(file, "", std::ref(read_placed)).resolve(whole);
    return whole;
  };
  IncludeResolver resolver(path, options.assets, std::ref(read));
  resolver.resolve(loaded);
  for (const v1::Include& placement : options.placements) {
    if (placement.file().empty())
      place_itself(loaded.scene, placement.transform());
    else
      resolver.place(loaded, placement, read_whole);
  }
}

/// That ReadOptions::up has no effect.
void warn_of_up(LoadedScene& loaded, const std::string& path, const ReadOptions& options) {
  const bool turns = options.brings_camera || !options.environment.empty();
  if (options.up == ReadOptions::Up::by_format || turns) return;
  add_warning(
      loaded, path,
      "--up: turns nothing; expected a model by itself, --view, --turntable or --environment");
}

/// Puts ReadOptions::environment around the scene.
void surround(LoadedScene& loaded, bool z_is_up, const ReadOptions& options) {
  if (options.environment.empty()) return;
  v1::Scene& scene = loaded.scene;
  std::string name = "environment";
  const auto is_taken = [&](const v1::Texture& texture) { return texture.name() == name; };
  while (std::any_of(scene.textures().begin(), scene.textures().end(), is_taken)) name += '_';
  v1::Texture& texture = *scene.add_textures();
  texture.set_name(name);
  const std::string file = fs::path(options.environment).filename().string();
  texture.mutable_image()->set_file(file);
  load_textures(loaded, AssetFolder(options.environment), options);
  texture.mutable_image()->set_file(to_utf8(file));
  scene.clear_background();
  scene.mutable_background()->mutable_panorama()->set_texture(name);
  if (z_is_up) stand_up(*scene.mutable_background()->mutable_orientation());
}

/// Does what ReadOptions::two_sided asks for.
void show_back_faces(v1::Scene& scene, const ReadOptions& options) {
  if (!options.two_sided) return;
  for (v1::Material& material : *scene.mutable_materials())
    if (material.sides() == v1::Material::FRONT_ONLY) material.set_sides(v1::Material::TWO_SIDED);
}

/// Does what ReadOptions::strict asks for.
void check_strictly(const LoadedScene& loaded, const ReadOptions& options) {
  if (!options.strict) return;
  AllFailures failures;
  for (const Diagnostic& repair : loaded.repairs)
    failures.add(scene_error(
        repair.place, repair.found,
        repair.expected + (repair.suggestion.empty()
                               ? ""
                               : fmt::format("; did you mean '{}'?", repair.suggestion))));
  failures.throw_if_any();
}

}  // namespace

void check_scene_format(const std::string& path, const ReadOptions& options) {
  const InputScope scope(&options.text_of);
  check_input_file(path, UINT64_MAX);
  format_of(path, options.format);
}

void add_files(LoadedScene& made, const std::string& name, const ReadOptions& options) {
  warn_of_up(made, name, options);
  surround(made, options.up == ReadOptions::Up::z, options);
  if (!made.scene.includes().empty() || !options.placements.empty()) {
    const InputScope scope(&options.text_of);
    FileReader read(name, options);
    add_others(name, options, read, made);
    check_scene(made.scene, name);
  }
  show_back_faces(made.scene, options);
  check_strictly(made, options);
}

LoadedScene read_scene(const std::string& path, const ReadOptions& options) {
  const InputScope scope(&options.text_of);
  FileReader read(path, options);
  LoadedScene loaded = read(path, options.format);
  add_others(path, options, read, loaded);
  show_back_faces(loaded.scene, options);
  const std::string format = format_of(path, options.format);
  const bool z_is_up = options.up == ReadOptions::Up::z ||
                       (options.up == ReadOptions::Up::by_format && format == "stl");
  surround(loaded, z_is_up, options);
  if (std::find(kModels.begin(), kModels.end(), format) != kModels.end()) {
    add_default_view(loaded, z_is_up, options);
  } else {
    warn_of_up(loaded, path, options);
  }
  if (!own_encoding(format) && loaded.scene.metadata().source_file().empty())
    loaded.scene.mutable_metadata()->set_source_file(to_utf8(fs::path(path).filename().string()));
  if (options.origins) loaded.origins.settle(loaded.scene);
  check_scene(loaded.scene, path);
  check_strictly(loaded, options);
  return loaded;
}

}  // namespace tessera
