// Prototypes of other files, which EXTERNPROTO names.
#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "base/file.h"
#include "scenes/formats/x3d/document/x3d_tree.h"
#include "scenes/formats/x3d/x3d_translator.h"

namespace tessera {
namespace {

/// What is behind '#' in a URL: the name of a prototype; empty: the file's first one.
std::string prototype_name(const std::string& url) {
  const size_t mark = url.find('#');
  return mark == std::string::npos ? "" : url.substr(mark + 1);
}

class X3dPrototypeSearch {
 public:
  X3dPrototypeSearch(X3dBuild& build, const std::string& folder) : build_(build), folder_(folder) {}

  /// Null, and why, where the URL names no prototype. `takes_others`: of another file, with a
  /// warning, as an Inline's.
  const X3dPrototype* find(const std::string& url, bool takes_others, bool quotes_strings,
                           std::string& reason) {
    X3dFiles& files = build_.files;
    const X3dFiles::Found found = files.find(url, folder_, takes_others);
    reason = found.reason;
    if (found.file.empty()) return nullptr;
    const X3dDocument* const document = read(found.file, reason);
    if (!document) return nullptr;
    reason = "strings are written otherwise there";
    if (document->quotes_strings() != quotes_strings) return nullptr;
    const X3dPrototypes& all = document->prototypes();
    const std::string asked = prototype_name(url);
    const auto known = all.by_name.find(asked.empty() ? all.first : asked);
    reason = asked.empty() ? "the file has no prototype"
                           : fmt::format("the file has no prototype '{}'", asked);
    if (known == all.by_name.end()) return nullptr;
    if (!found.note.empty())
      add_warning(build_.out, files.full(files.open.back()), "the prototype's file " + found.note);
    return &known->second;
  }

 private:
  /// Null, and why, where the file cannot be read.
  const X3dDocument* read(const std::string& file, std::string& reason) {
    X3dFiles& files = build_.files;
    if (std::ranges::find(files.open, file) != files.open.end()) {
      reason = "it is a part of that file";
      return nullptr;
    }
    if (const auto known = files.prototypes.find(file); known != files.prototypes.end())
      return known->second.get();
    if (const auto known = files.problems.find(file); known != files.problems.end()) {
      reason = known->second;
      return nullptr;
    }
    if (files.is_full()) {
      reason = fmt::format("too many files; expected at most {}, {} one inside the other",
                           X3dFiles::kMaxFiles, X3dFiles::kMaxOpen);
      return nullptr;
    }
    files.open.push_back(file);
    const std::string full = files.full(file);
    try {
      auto document = std::make_shared<X3dDocument>(
          X3dDocument::parse(read_input_file(full, X3dDocument::kMaxBytes), full,
                             build_.prototype_finder(X3dFiles::folder_of(file))));
      check_size(*document);
      files.open.pop_back();
      return keep(file, full, std::move(document));
    } catch (const Error& error) {
      files.open.pop_back();
      if (error.code() != ExitCode::bad_scene) throw;
      reason = files.problems[file] = error.what();
      return nullptr;
    }
  }

  /// Throws where it and those that are kept are more than one file may be.
  void check_size(const X3dDocument& document) {
    X3dFiles& files = build_.files;
    files.prototype_nodes += document.node_count();
    files.prototype_bytes += document.length();
    if (files.prototype_nodes > X3dTree::kMaxCopies ||
        files.prototype_bytes > X3dDocument::kMaxBytes)
      throw document.error(0, "too much with the other files of prototypes",
                           fmt::format("at most {} nodes and {} MiB in all", X3dTree::kMaxCopies,
                                       X3dDocument::kMaxBytes >> 20));
  }

  const X3dDocument* keep(const std::string& file, const std::string& full,
                          std::shared_ptr<X3dDocument> document) {
    Warnings warnings;
    X3dValues(*document, warnings).tell_remarks();
    warnings.add_to(build_.out, full);
    const auto at = build_.files.prototypes.emplace(file, document).first;
    document->set_file_of_prototypes(&at->first);
    return document.get();
  }

  X3dBuild& build_;
  const std::string& folder_;
};

}  // namespace

X3dPrototypeFinder X3dBuild::prototype_finder(const std::string& folder) {
  if (!files.has_folder()) return {};
  return [this, folder](const std::vector<std::string>& urls, bool quotes_strings,
                        std::string& reason) -> const X3dPrototype* {
    X3dPrototypeSearch search(*this, folder);
    std::string why, ignored;
    for (const std::string& url : urls) {
      if (const X3dPrototype* const found = search.find(url, false, quotes_strings, why))
        return found;
      reason += fmt::format("{}'{}': {}", reason.empty() ? "" : "; ", X3dFiles::shown(url), why);
    }
    for (const std::string& url : urls)
      if (const X3dPrototype* const found = search.find(url, true, quotes_strings, ignored))
        return found;
    if (urls.empty()) reason = "it has no URL";
    return nullptr;
  };
}

}  // namespace tessera
