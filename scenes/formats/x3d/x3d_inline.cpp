#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/error.h"
#include "base/file.h"
#include "scenes/formats/x3d/x3d_translator.h"

namespace tessera {
namespace {

/// Whether the file's ending says that it is of another format, which other readers know.
bool is_other_format(const std::string& file) {
  constexpr std::array<std::string_view, 9> kEndings{
      ".obj", ".gltf", ".glb", ".ply", ".stl", ".crt", ".tessera", ".tesserab", ".json"};
  std::string lower = file;
  for (char& c : lower) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c + 32 : c);
  return std::any_of(kEndings.begin(), kEndings.end(),
                     [&](std::string_view ending) { return lower.ends_with(ending); });
}

std::string stem(const std::string& file) {
  const std::string name = file.substr(file.rfind('/') + 1);
  return to_utf8(name.substr(0, name.rfind('.')));
}

/// Takes what a file that turns out to be wrong has put into the scene out of it again.
class X3dUndo {
 public:
  explicit X3dUndo(X3dBuild& build)
      : build_(build),
        cameras_(scene().cameras_size()),
        materials_(scene().materials_size()),
        textures_(scene().textures_size()),
        objects_(scene().objects_size()),
        includes_(scene().includes_size()),
        has_background_(scene().has_background()),
        has_scene_fog_(scene().has_fog()),
        has_fog_(build.has_fog),
        has_navigation_(build.has_navigation),
        headlight_(build.headlight),
        depth_(build.depth),
        warnings_(build.out.warnings.size()),
        repairs_(build.out.repairs.size()),
        placeholder_(build.placeholder),
        open_(build.files.open),
        known_(build.files.objects) {}

  void operator()() const {
    cut(*scene().mutable_cameras(), cameras_);
    cut(*scene().mutable_materials(), materials_);
    cut(*scene().mutable_textures(), textures_);
    cut(*scene().mutable_objects(), objects_);
    cut(*scene().mutable_includes(), includes_);
    if (!has_background_) scene().clear_background();
    if (!has_scene_fog_) scene().clear_fog();
    build_.has_fog = has_fog_;
    build_.has_navigation = has_navigation_;
    build_.headlight = headlight_;
    build_.depth = depth_;
    build_.out.warnings.resize(warnings_);
    build_.out.warning_diagnostics.resize(warnings_);
    build_.out.repairs.resize(repairs_);
    build_.placeholder = placeholder_;
    build_.files.open = open_;
    build_.files.objects = known_;
  }

 private:
  template <typename Messages>
  static void cut(Messages& messages, int size) {
    messages.DeleteSubrange(size, messages.size() - size);
  }
  v1::Scene& scene() const { return build_.out.scene; }

  X3dBuild& build_;
  int cameras_, materials_, textures_, objects_, includes_;
  bool has_background_, has_scene_fog_, has_fog_, has_navigation_, headlight_;
  int depth_;
  size_t warnings_, repairs_;
  std::string placeholder_;
  std::vector<std::string> open_;
  std::map<std::string, std::string> known_;
};

}  // namespace

/// What another file shows becomes an object, once for each file. The first URL whose file can be
/// read holds.
void X3dTranslator::add_inline(const X3dNode& node, const v1::Transform& path, v1::Node& out) {
  if (!values_.boolean(node, "load", true)) return;
  const auto urls = values_.strings(node, "url");
  if (urls.empty()) return;
  std::string reasons;
  for (const std::string& url : urls) {
    const std::string reason = read_inline(node, url, false, path, out);
    if (reason.empty()) return;
    reasons += reasons.empty() ? reason : fmt::format("; '{}': {}", X3dFiles::shown(url), reason);
  }
  for (const std::string& url : urls)
    if (read_inline(node, url, true, path, out).empty()) return;
  if (build_.options.x3d_strict)
    throw document_.error(node.offset,
                          fmt::format("Inline of '{}': {}", X3dFiles::shown(urls[0]), reasons),
                          "a file that can be read");
  values_.warn(node.offset,
               fmt::format("Inline of '{}' is left out: {}", X3dFiles::shown(urls[0]), reasons));
}

/// Why what the URL names is no part of the scene; empty where it is. `takes_others`: another file
/// may be taken for it, with a warning.
std::string X3dTranslator::read_inline(const X3dNode& node, const std::string& url,
                                       bool takes_others, const v1::Transform& path,
                                       v1::Node& out) {
  X3dFiles& files = build_.files;
  if (!files.has_folder()) return "no folder is known";
  const X3dFiles::Found found = files.find(url, folder_of(node), takes_others);
  if (found.file.empty()) return found.reason;
  const bool is_other = !found.note.empty();
  const auto endless = [&](const std::string& what, const std::string& expected) {
    files.is_endless = true;
    return document_.error(node.offset, what, expected);
  };
  const bool is_open =
      std::find(files.open.begin(), files.open.end(), found.file) != files.open.end();
  if (is_open && is_other) return "it is a part of the only file of that name";
  if (is_open)
    throw endless(fmt::format("Inline of '{}', of which it is a part", url),
                  "files that are not a part of themselves");
  if (const auto known = files.objects.find(found.file); known != files.objects.end()) {
    out.set_instance_of(known->second);
    if (is_other) values_.warn(node.offset, "the Inline " + found.note);
    return "";
  }
  if (const auto known = files.problems.find(found.file); known != files.problems.end())
    return known->second;
  if (files.is_full())
    throw endless("too many Inlines", fmt::format("at most {} files, {} one inside the other",
                                                  X3dFiles::kMaxFiles, X3dFiles::kMaxOpen));

  const X3dUndo undo(build_);
  try {
    const std::string name = build_.unique(build_.object_names, stem(found.file));
    files.objects.emplace(found.file, name);
    out.set_instance_of(name);
    add_file(found.file, name, path);
    if (is_other) values_.warn(node.offset, "the Inline " + found.note);
    return "";
  } catch (const Error& error) {  // as one that is missing
    if (files.is_endless || error.code() != ExitCode::bad_scene) throw;
    undo();
    out.clear_instance_of();
    return files.problems[found.file] = error.what();
  }
}

/// Adds what the file shows as the object of that name. Throws where it cannot be read.
void X3dTranslator::add_file(const std::string& file, const std::string& name,
                             const v1::Transform& path) {
  X3dFiles& files = build_.files;
  const std::string full = files.full(file);
  if (is_other_format(file)) {
    const SceneCheck& check = build_.options.check_scene;
    if (const std::string problem = check ? check(full) : ""; !problem.empty())
      throw scene_error(problem);
    v1::Include& include = *out_.scene.add_includes();
    include.set_file(file);
    include.set_object(name);
    *include.mutable_transform() = path;
    return;
  }
  files.open.push_back(file);
  const std::string folder = X3dFiles::folder_of(file);
  const X3dDocument document = X3dDocument::parse(read_input_file(full, X3dDocument::kMaxBytes),
                                                  full, build_.prototype_finder(folder));
  v1::Object object;
  object.set_name(name);
  X3dTranslator(document, build_, folder)
      .add_all(path, document_.metres_per_unit(), *object.mutable_nodes());
  *out_.scene.add_objects() = std::move(object);
  files.open.pop_back();
}

}  // namespace tessera
