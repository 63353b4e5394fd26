#include "studio/files/draft_store.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <utility>

#include "base/descriptors.h"
#include "base/error.h"
#include "base/file.h"
#include "base/folder.h"
#include "base/open_file.h"
#include "studio/files/new_file.h"
#include "studio/files/user_folder.h"

namespace tessera {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// A draft is the file DOCUMENT.PROGRAM.draft: a line of JSON and then the text. PROGRAM.running is
// locked by the program while it runs.
constexpr std::string_view kDraft = ".draft", kRunning = ".running";
constexpr uint64_t kLongestHead = 64 << 10;
/// Nobody still writes what is older.
constexpr std::chrono::hours kLongestWrite{1};

std::string name_of_document(const std::string& folder, const std::string& file) {
  return Digest::of(fmt::format("{}{}{}", folder, '\0', file)).hex();
}

std::string encode(const TextDraft& draft) {
  const json head{{"folder", draft.folder},
                  {"file", draft.file},
                  {"base", draft.base.hex()},
                  {"saved_at", draft.saved_at},
                  {"text", Digest::of(draft.text).hex()}};
  return head.dump(-1, ' ', false, json::error_handler_t::replace) + '\n' + draft.text;
}

std::optional<TextDraft> decode(const std::string& bytes) {
  const size_t end = bytes.find('\n');
  if (end == std::string::npos || end > kLongestHead) return std::nullopt;
  try {
    const json head = json::parse(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(end));
    TextDraft draft{.folder = head.at("folder").get<std::string>(),
                    .file = head.at("file").get<std::string>(),
                    .base = Digest::from_hex(head.at("base").get<std::string>()),
                    .saved_at = head.at("saved_at").get<int64_t>(),
                    .text = bytes.substr(end + 1)};
    if (Digest::of(draft.text).hex() != head.at("text").get<std::string>()) return std::nullopt;
    return draft;
  } catch (const json::exception&) {  // no JSON, or other than expected
    return std::nullopt;
  }
}

OwnedDescriptor open_file(const fs::path& path, int flags) {
  const SpareDescriptors spare;
  return OwnedDescriptor(::open(path.c_str(), flags | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0600));
}

std::optional<std::string> read_whole(const fs::path& path, uint64_t most_bytes) {
  const OwnedDescriptor file = open_file(path, O_RDONLY);
  struct stat status;
  if (file.get() < 0 || ::fstat(file.get(), &status) != 0) return std::nullopt;
  const auto size = static_cast<uint64_t>(status.st_size);
  if (!S_ISREG(status.st_mode) || size > most_bytes) return std::nullopt;
  std::string bytes(size, '\0');
  if (!read_all_at(file.get(), 0, std::as_writable_bytes(std::span(bytes)))) return std::nullopt;
  return bytes;
}

}  // namespace

fs::path DraftStore::default_folder() {
  const fs::path folder = user_folder("XDG_STATE_HOME", ".local/state");
  return folder.empty() ? folder : folder / "studio";
}

DraftStore::DraftStore(fs::path folder, uint64_t most_bytes)
    : folder_(std::move(folder)), most_bytes_(most_bytes) {
  constexpr int kMostTries = 20;
  make_private_folder(folder_);
  bool is_held = false;
  // Another program that looks whether this one runs may hold its file for a moment.
  for (int i = 0; i < kMostTries && !is_held; ++i) {
    program_ = unique_name();
    running_ =
        open_file(folder_ / fmt::format("{}{}", program_, kRunning), O_RDWR | O_CREAT | O_EXCL);
    struct stat status;
    is_held = running_.get() >= 0 && hold_alone(running_.get(), status);
  }
  if (!is_held)
    throw render_error(
        fmt::format("'{}' cannot be written: {}", folder_.string(), std::strerror(errno)));
  remove_traces_of_ended();
}

DraftStore::~DraftStore() { ::unlink((folder_ / fmt::format("{}{}", program_, kRunning)).c_str()); }

bool DraftStore::runs(const std::string& program) const {
  const OwnedDescriptor mark = open_file(folder_ / fmt::format("{}{}", program, kRunning), O_RDWR);
  struct stat status;
  return mark.get() >= 0 && !hold_alone(mark.get(), status);
}

void DraftStore::remove_traces_of_ended() const {
  for (const auto& entry : entries_in(folder_)) {
    const std::string name = entry.path().filename().string();
    if (name.ends_with(kRunning)) {
      const std::string program = name.substr(0, name.size() - kRunning.size());
      if (program != program_ && !runs(program)) ::unlink(entry.path().c_str());
    } else if (is_unfinished_output(name)) {
      std::error_code failure;
      const auto age = fs::file_time_type::clock::now() - entry.last_write_time(failure);
      if (!failure && age > kLongestWrite) ::unlink(entry.path().c_str());
    }
  }
}

std::vector<DraftStore::Entry> DraftStore::entries(uint64_t* bytes_of_others) const {
  std::vector<Entry> out;
  for (const auto& file : entries_in(folder_)) {
    const std::string name = file.path().filename().string();
    struct stat status;
    if (!name.ends_with(kDraft) || ::lstat(file.path().c_str(), &status) != 0) continue;
    const size_t dot = name.find('.');
    const std::string program =
        name.substr(std::min(dot + 1, name.size()),
                    name.size() - kDraft.size() - std::min(dot + 1, name.size()));
    const auto size = static_cast<uint64_t>(status.st_size);
    if (program != program_ && runs(program)) {
      if (bytes_of_others != nullptr) *bytes_of_others += size;
      continue;
    }
    out.push_back({file.path(), name.substr(0, dot), program, size,
                   status.st_mtim.tv_sec * 1'000'000'000 + status.st_mtim.tv_nsec});
  }
  std::sort(out.begin(), out.end(), [](const Entry& a, const Entry& b) {
    return std::pair(a.written, a.path) < std::pair(b.written, b.path);
  });
  return out;
}

void DraftStore::put(const TextDraft& draft) const {
  const std::string bytes = encode(draft);
  const std::string document = name_of_document(draft.folder, draft.file);
  const fs::path path = folder_ / fmt::format("{}.{}{}", document, program_, kDraft);
  uint64_t total = bytes.size();
  std::vector<Entry> there = entries(&total);
  std::erase_if(there, [&](const Entry& entry) { return entry.path == path; });
  for (const Entry& entry : there) total += entry.size;
  for (const Entry& entry : there) {
    if (total <= most_bytes_) break;
    total -= entry.size;
    ::unlink(entry.path.c_str());
  }
  if (total > most_bytes_)
    throw render_error(fmt::format("the draft of '{}' is not kept: drafts may have {} bytes in all",
                                   draft.file, most_bytes_));
  NewFile file(open_file(folder_, O_RDONLY | O_DIRECTORY), path.filename().string(), path.string(),
               0600);
  file.append(bytes);
  file.finish_over();
}

std::vector<KeptDraft> DraftStore::find(const std::string& folder, const std::string& file) const {
  const std::string document = name_of_document(folder, file);
  std::vector<KeptDraft> found;
  for (const Entry& entry : entries()) {
    if (entry.document != document) continue;
    const auto bytes = read_whole(entry.path, most_bytes_);
    std::optional<TextDraft> draft = bytes ? decode(*bytes) : std::nullopt;
    if (!draft || draft->folder != folder || draft->file != file) {
      ::unlink(entry.path.c_str());
    } else {
      found.push_back({entry.program, std::move(*draft)});
    }
  }
  std::reverse(found.begin(), found.end());
  std::ranges::stable_sort(found, std::ranges::greater(),
                           [](const KeptDraft& kept) { return kept.draft.saved_at; });
  return found;
}

void DraftStore::drop_own(const std::string& folder, const std::string& file) const {
  drop(folder, file, {program_});
}

void DraftStore::drop(const std::string& folder, const std::string& file,
                      const std::vector<std::string>& programs) const {
  const std::string document = name_of_document(folder, file);
  for (const Entry& entry : entries()) {
    if (entry.document == document && std::ranges::find(programs, entry.program) != programs.end())
      ::unlink(entry.path.c_str());
  }
}

}  // namespace tessera
