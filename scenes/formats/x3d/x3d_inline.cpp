#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>

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

}  // namespace

/// What another file shows becomes an object, once for each file. The first URL whose file can be
/// read holds.
void X3dTranslator::add_inline(const X3dNode& node, const v1::Transform& path, v1::Node& out) {
  if (!values_.boolean(node, "load", true)) return;
  const auto urls = values_.strings(node, "url");
  if (urls.empty()) return;
  std::string reasons;
  for (const std::string& url : urls) {
    const std::string reason = read_inline(node, url, path, out);
    if (reason.empty()) return;
    reasons += reasons.empty() ? reason : fmt::format("; '{}': {}", X3dFiles::shown(url), reason);
  }
  if (build_.options.x3d_strict)
    throw document_.error(node.offset,
                          fmt::format("Inline of '{}': {}", X3dFiles::shown(urls[0]), reasons),
                          "a file that can be read");
  warnings_.add(fmt::format("line {}: Inline of '{}' is left out: {}",
                            document_.place(node.offset).line, X3dFiles::shown(urls[0]), reasons));
}

/// Why what the URL names is no part of the scene; empty where it is.
std::string X3dTranslator::read_inline(const X3dNode& node, const std::string& url,
                                       const v1::Transform& path, v1::Node& out) {
  X3dFiles& files = build_.files;
  if (!files.has_folder()) return "no folder is known";
  const X3dFiles::Found found = files.find(url, folder_);
  if (found.file.empty()) return found.reason;
  if (std::find(files.open.begin(), files.open.end(), found.file) != files.open.end())
    throw document_.error(node.offset, fmt::format("Inline of '{}', of which it is a part", url),
                          "files that are not a part of themselves");
  const auto known = files.objects.find(found.file);
  if (known != files.objects.end()) {
    out.set_instance_of(known->second);
    return "";
  }
  if (files.open.size() >= X3dFiles::kMaxOpen || files.objects.size() >= X3dFiles::kMaxFiles)
    throw document_.error(node.offset, "too many Inlines",
                          fmt::format("at most {} files, {} one inside the other",
                                      X3dFiles::kMaxFiles, X3dFiles::kMaxOpen));

  const bool is_other = is_other_format(found.file);
  const std::string full = files.full(found.file);
  std::optional<X3dDocument> parsed;
  try {
    if (!is_other) parsed = X3dDocument::parse(read_input_file(full, X3dDocument::kMaxBytes), full);
    const SceneCheck& check = build_.options.check_scene;
    if (const std::string problem = is_other && check ? check(full) : ""; !problem.empty())
      return problem;
  } catch (const Error& error) {  // as one that is missing
    return error.what();
  }
  const std::string name = build_.unique(build_.object_names, stem(found.file));
  files.objects.emplace(found.file, name);
  out.set_instance_of(name);
  if (is_other) {
    v1::Include& include = *out_.scene.add_includes();
    include.set_file(found.file);
    include.set_object(name);
    *include.mutable_transform() = path;
    return "";
  }
  const X3dDocument& document = *parsed;
  files.open.push_back(found.file);
  v1::Object object;
  object.set_name(name);
  X3dTranslator(document, build_, X3dFiles::folder_of(found.file))
      .add_all(path, document_.metres_per_unit(), *object.mutable_nodes());
  *out_.scene.add_objects() = std::move(object);
  files.open.pop_back();
  return "";
}

}  // namespace tessera
