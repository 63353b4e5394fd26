#include "base/file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <cstdio>
#include <cstring>
#include <memory>
#include <system_error>
#include <utility>
#include <vector>

#include "base/cancellation.h"
#include "base/descriptors.h"
#include "base/error.h"
#include "base/folder.h"
#include "base/input_scope.h"
#include "base/missing_file.h"
#include "base/open_file.h"
#include "base/open_input.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// As scene_error() of a whole message.
Error file_error(const std::string& path, std::string_view found) {
  return scene_error(fmt::format("{}: {}", path, found), {make_diagnostic({path}, found, "")});
}

/// "; did you mean 'x'?" for the file beside `path` that is nearest to it.
std::string near_file(const fs::path& path) {
  constexpr size_t kMostEntries = 10000;
  std::vector<std::string> names;
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  for (const auto& entry : entries_in(folder, kMostEntries)) {
    std::error_code unknown;
    if (entry.is_regular_file(unknown)) names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  const auto nearest = nearest_name(path.filename().string(), names);
  if (!nearest) return "";
  return fmt::format("; did you mean '{}'?", (path.parent_path() / *nearest).string());
}

}  // namespace

bool is_input_file(const fs::path& path) {
  InputScope::note(path);
  std::error_code ignored;
  return InputScope::text_of(path) != nullptr || fs::is_regular_file(path, ignored);
}

namespace {

uint64_t check_size(const std::string& path, uint64_t size, uint64_t max_bytes) {
  if (size == 0) throw file_error(path, "the file is empty");
  if (size > max_bytes) {
    throw file_error(path,
                     fmt::format("the file has {} bytes; expected at most {}", size, max_bytes));
  }
  return size;
}

/// Throws where a repository was cloned without the file's content, which Git LFS keeps elsewhere
/// and puts a few lines in place of (its specification, docs/spec.md).
void check_content_is_here(const std::string& path, uint64_t size) {
  constexpr std::string_view kStart = "version https://git-lfs.github.com/spec/";
  constexpr uint64_t kMostBytes = 1024;  // of such lines
  if (size < kStart.size() || size > kMostBytes) return;
  const InputFile file = open_input_file(path);
  std::array<char, kStart.size()> head{};
  if (!file || std::fread(head.data(), 1, head.size(), file.get()) != head.size()) return;
  if (std::string_view(head.data(), head.size()) != kStart) return;
  throw scene_error({path}, "a Git LFS pointer in place of the file's content",
                    "the content, which 'git lfs pull' fetches");
}

}  // namespace

uint64_t check_input_file(const std::string& path, uint64_t max_bytes) {
  InputScope::note(path);
  if (const auto text = InputScope::text_of(path)) return check_size(path, text->size(), max_bytes);
  std::error_code failure;
  const fs::file_status status = fs::status(path, failure);
  if (status.type() == fs::file_type::not_found)
    throw MissingFileError(path, fmt::format("no such file{}", near_file(path)));
  if (failure) throw file_error(path, failure.message());
  if (fs::is_directory(status)) throw file_error(path, "is a folder; expected a file");
  if (!fs::is_regular_file(status)) throw file_error(path, "is no regular file");
  const uint64_t size = fs::file_size(path, failure);
  if (failure) throw file_error(path, failure.message());
  check_content_is_here(path, size);
  return check_size(path, size, max_bytes);
}

std::string read_input_file(const std::string& path, uint64_t max_bytes) {
  const uint64_t size = check_input_file(path, max_bytes);
  if (const auto text = InputScope::text_of(path)) return *text;
  const InputFile file = open_input_file(path);
  if (!file) throw file_error(path, std::strerror(errno));
  std::string bytes(size, '\0');
  const size_t got = std::fread(bytes.data(), 1, size, file.get());
  if (std::ferror(file.get())) throw file_error(path, std::strerror(errno));
  bytes.resize(got);
  return bytes;
}

namespace {

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

}  // namespace

fs::path output_place(const fs::path& path) {
  constexpr int kMostLinks = 40;  // as the kernel
  std::error_code failure;
  fs::path place = path;
  for (int i = 0; i < kMostLinks && fs::is_symlink(place, failure); ++i) {
    place = folder_of(place) / fs::read_symlink(place, failure);
  }
  const fs::path whole = fs::weakly_canonical(fs::absolute(place, failure), failure);
  return failure ? place : whole;
}

namespace {

/// Why nothing can be written at `path`; empty where something can.
std::string output_refusal(const fs::path& path) {
  std::error_code failure;
  const fs::file_status status = fs::status(path, failure);
  if (path.filename().empty() || fs::is_directory(status)) return "it is a folder";
  if (failure && status.type() == fs::file_type::none) return failure.message();
  if (fs::exists(status) && !fs::is_regular_file(status)) return "it is no regular file";
  const fs::path place = output_place(path);
  const fs::path folder = folder_of(place);
  if (!fs::is_directory(folder, failure)) {
    return fmt::format("there is no folder '{}'", folder.string());
  }
  if (access(folder.c_str(), W_OK | X_OK) != 0) return std::strerror(errno);
  if (fs::exists(status) && access(place.c_str(), W_OK) != 0) return std::strerror(errno);
  return {};
}

constexpr std::string_view kUnfinishedStart = ".tessera-", kUnfinishedEnd = ".part";

/// The file under way, where a signal handler may read it: written while the flag is down.
std::array<char, PATH_MAX> unfinished_path;
std::atomic<bool> unfinished{false};
static_assert(std::atomic<bool>::is_always_lock_free, "it is read in a signal handler");

/// A new file in `folder` that goes away unless it is renamed. Every step tells whether it was
/// done; errno tells why not.
class UnfinishedFile {
 public:
  explicit UnfinishedFile(const fs::path& folder)
      : path_(folder / fmt::format("{}{}{}", kUnfinishedStart, unique_name(), kUnfinishedEnd)) {}
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;
  ~UnfinishedFile() {
    if (file_ >= 0) ::close(file_);
    if (unfinished) ::unlink(path_.c_str());
    unfinished = false;
  }

  bool create() {
    if (path_.native().size() >= unfinished_path.size()) return errno = ENAMETOOLONG, false;
    unfinished_path[path_.native().copy(unfinished_path.data(), PATH_MAX - 1)] = '\0';
    unfinished = true;
    const SpareDescriptors spare;
    file_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    return file_ >= 0;
  }

  bool write(std::string_view bytes) {
    constexpr size_t kPiece = size_t{16} << 20;
    for (size_t at = 0; at < bytes.size(); at += kPiece) {
      const std::atomic<bool>* const cancelled = Cancellation::current();
      if (cancelled && *cancelled) throw WorkCancelled{};
      if (!write_all(file_, std::as_bytes(std::span(bytes.substr(at, kPiece))))) return false;
    }
    return ::fsync(file_) == 0 && ::close(std::exchange(file_, -1)) == 0;
  }

  bool rename_to(const fs::path& place) {
    if (std::rename(path_.c_str(), place.c_str()) != 0) return false;
    unfinished = false;
    sync_folder(folder_of(place));
    return true;
  }

 private:
  fs::path path_;
  int file_ = -1;
};

}  // namespace

void check_output_file(const std::string& path, std::string_view option) {
  const std::string why = output_refusal(path);
  if (why.empty()) return;
  throw usage_error(fmt::format("{}'{}' cannot be written: {}",
                                option.empty() ? "" : fmt::format("{}: ", option), path, why));
}

void check_not_input(const std::string& output, const std::string& input, std::string_view option) {
  std::error_code failure;
  if (!fs::equivalent(output, input, failure)) return;
  throw usage_error(
      fmt::format("{}: '{}' is the file that is read; expected another", option, output));
}

void write_output_file(const std::string& path, std::string_view bytes) {
  std::string why = output_refusal(path);
  if (why.empty()) {
    const fs::path place = output_place(path);
    UnfinishedFile file(folder_of(place));
    if (file.create() && file.write(bytes) && file.rename_to(place)) return;
    why = std::strerror(errno);
  }
  throw render_error(fmt::format("'{}' cannot be written: {}", path, why));
}

bool is_unfinished_output(std::string_view name) {
  return name.starts_with(kUnfinishedStart) && name.ends_with(kUnfinishedEnd);
}

void remove_unfinished_output() {
  if (unfinished) ::unlink(unfinished_path.data());
}

std::optional<fs::path> resolve_inside(const fs::path& folder, const std::string& reference) {
  if (reference.empty() || reference.find('\0') != std::string::npos) return std::nullopt;
  const fs::path relative(reference);
  if (relative.is_absolute()) return std::nullopt;
  std::error_code failure;
  const fs::path root = fs::weakly_canonical(folder.empty() ? "." : folder, failure);
  if (failure) return std::nullopt;
  const fs::path target = fs::weakly_canonical(root / relative, failure);
  InputScope::note(root / relative);
  if (failure) return std::nullopt;
  const fs::path inside = target.lexically_relative(root);
  if (inside.empty() || *inside.begin() == "..") return std::nullopt;
  // A link to nothing is not followed: it would lead out as soon as there were something.
  fs::path part = root;
  for (const fs::path& step : inside) {
    if (fs::is_symlink(part /= step, failure)) return std::nullopt;
  }
  return target;
}

namespace {

/// The length of the well-formed UTF-8 sequence (RFC 3629) at `at`, or 0.
size_t utf8_sequence(std::string_view text, size_t at) {
  const auto byte = [&](size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u;
  };
  const unsigned first = byte(at);
  if (first < 0x80) return 1;
  const size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4) return 0;
  for (size_t i = 1; i < length; ++i)
    if ((byte(at + i) & 0xC0) != 0x80) return 0;
  const unsigned second = byte(at + 1);
  const bool overlong = (first == 0xE0 && second < 0xA0) || (first == 0xF0 && second < 0x90);
  const bool surrogate = first == 0xED && second > 0x9F;
  const bool too_large = first == 0xF4 && second > 0x8F;
  return overlong || surrogate || too_large ? 0 : length;
}

}  // namespace

std::string_view skip_byte_order_mark(std::string_view text) {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  while (text.starts_with(kMark)) text.remove_prefix(kMark.size());  // some add one more each time
  return text;
}

size_t find_invalid_utf8(std::string_view text) {
  for (size_t at = 0; at < text.size();) {
    const size_t length = utf8_sequence(text, at);
    if (length == 0) return at;
    at += length;
  }
  return std::string_view::npos;
}

std::string to_utf8(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (size_t at = 0; at < text.size();) {
    if (const size_t length = utf8_sequence(text, at)) {
      out.append(text.substr(at, length));
      at += length;
      continue;
    }
    const auto byte = static_cast<unsigned char>(text[at++]);
    out += static_cast<char>(0xC0 | byte >> 6);
    out += static_cast<char>(0x80 | (byte & 0x3F));
  }
  return out;
}

}  // namespace tessera
