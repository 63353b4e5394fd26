#include "scenes/formats/x3d/x3d_files.h"

#include <fmt/format.h>

#include "base/file.h"
#include "base/lower_case.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

int hex_digit(char c) {
  return c >= '0' && c <= '9'   ? c - '0'
         : c >= 'a' && c <= 'f' ? c - 'a' + 10
         : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                : -1;
}

/// Without what follows '#', which names a part of the file.
std::string path_of(const std::string& url) {
  std::string out;
  for (size_t at = 0; at < url.size() && url[at] != '#'; ++at) {
    const bool coded = url[at] == '%' && at + 2 < url.size() && hex_digit(url[at + 1]) >= 0 &&
                       hex_digit(url[at + 2]) >= 0;
    out +=
        coded ? static_cast<char>(hex_digit(url[at + 1]) * 16 + hex_digit(url[at + 2])) : url[at];
    if (coded) at += 2;
  }
  return out;
}

/// Without "file:" and an authority that is this machine, in any case.
std::string without_file_scheme(const std::string& url) {
  const std::string lower = lower_case(url.substr(0, 18));
  for (const std::string_view start : {"file://localhost/", "file:///"})
    if (lower.starts_with(start)) return url.substr(start.size() - 1);
  return lower.starts_with("file:") && !lower.starts_with("file://") ? url.substr(5) : url;
}

/// Whether it begins "scheme:", with two letters or more.
bool has_scheme(const std::string& url) {
  const size_t colon = url.find(':');
  return colon != std::string::npos && colon > 1 && url.find_first_of("/\\.") > colon;
}

}  // namespace

X3dFiles::X3dFiles(const std::string& first_file, const std::string& assets)
    : assets_(AssetFolder(first_file, assets)) {
  const fs::path whole = whole_path(first_file);
  open.push_back(whole.lexically_relative(assets_->folder).generic_string());
}

std::string X3dFiles::folder_of(const std::string& file) {
  const size_t slash = file.rfind('/');
  return slash == std::string::npos ? "" : file.substr(0, slash);
}

X3dFiles::Found X3dFiles::find(const std::string& url, const std::string& folder,
                               bool takes_others) const {
  const std::string local = without_file_scheme(url);
  if (has_scheme(local)) return {.reason = "only files are read, and nothing from the network"};
  const std::string path = path_of(local);
  if (path.empty()) return {.reason = "it names no file"};
  AssetFolder from = *assets_;
  from.folder = (from.folder / folder).lexically_normal();
  const auto [target, note] =
      takes_others ? from.find_asset(path) : AssetFolder::Found{from.find(path)};
  if (!target) return {.reason = fmt::format("it is not inside {}", from.shown_root(path))};
  if (!is_input_file(*target)) return {.reason = "there is no such file"};
  return {.file = target->lexically_relative(assets_->folder).generic_string(), .note = note};
}

std::string X3dFiles::shown(const std::string& url) {
  constexpr size_t kLongest = 40;
  const bool is_cut = url.starts_with("data:") && url.size() > kLongest;
  return is_cut ? url.substr(0, kLongest) + "..." : url;
}

}  // namespace tessera
