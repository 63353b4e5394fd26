#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "base/digest.h"
#include "base/owned_descriptor.h"

namespace tessera {

/// The unsaved text of a document.
struct TextDraft {
  std::string folder;    ///< the opened folder, absolute
  std::string file;      ///< its name below the folder
  Digest base;           ///< of the file that was edited
  int64_t saved_at = 0;  ///< milliseconds since 1970
  std::string text;
  friend bool operator==(const TextDraft&, const TextDraft&) = default;
};

/// A draft that was found.
struct KeptDraft {
  std::string program;  ///< that put it
  TextDraft draft;
};

/// Drafts of this program and of those that ended without saving, in a folder that no other account
/// can read. A draft belongs to the program that put it: while that runs, no other finds, drops or
/// replaces it. Methods may be called by any thread.
class DraftStore {
 public:
  static constexpr uint64_t kMostBytes = uint64_t{64} << 20;

  /// $XDG_STATE_HOME/tessera/studio, or else the same in ~/.local/state; empty where there is
  /// neither.
  static std::filesystem::path default_folder();
  /// Makes the folder where it is not there. Throws render_error where that cannot be.
  explicit DraftStore(std::filesystem::path folder, uint64_t most_bytes = kMostBytes);
  ~DraftStore();
  DraftStore(const DraftStore&) = delete;
  DraftStore& operator=(const DraftStore&) = delete;

  /// Replaces this program's draft of that file: whole, or not at all. Where there are more than
  /// `most_bytes` in all, the oldest go, those of other programs that run excepted. Throws
  /// render_error.
  void put(const TextDraft& draft) const;
  /// Those of that file, the newest first; damaged ones are removed.
  std::vector<KeptDraft> find(const std::string& folder, const std::string& file) const;
  /// Removes this program's of that file.
  void drop_own(const std::string& folder, const std::string& file) const;
  /// Removes those that these programs put, unless they run.
  void drop(const std::string& folder, const std::string& file,
            const std::vector<std::string>& programs) const;

 private:
  /// A file of a draft.
  struct Entry {
    std::filesystem::path path;
    std::string document;  ///< names folder and file
    std::string program;   ///< that put it
    uint64_t size = 0;
    int64_t written = 0;  ///< nanoseconds since 1970
  };
  /// Those that this program may take: oldest first. The bytes of all others are added up.
  std::vector<Entry> entries(uint64_t* bytes_of_others = nullptr) const;
  bool runs(const std::string& program) const;
  void remove_traces_of_ended() const;

  std::filesystem::path folder_;
  uint64_t most_bytes_;
  std::string program_;      ///< this program's name in names of files
  OwnedDescriptor running_;  ///< a locked file: who holds it runs
};

}  // namespace tessera
