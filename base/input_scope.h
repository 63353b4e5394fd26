#pragma once

#include <sys/stat.h>

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>

namespace tessera {

/// The text that stands for the file of that whole path, such as that of an editor which is not
/// saved; null: there is none, and the file is read.
using TextOfFile =
    std::function<std::shared_ptr<const std::string>(const std::filesystem::path& whole_path)>;

/// What reading a file would give, as far as can be told without reading it.
class InputState {
 public:
  /// Of the file at `path` now, or of the text that stands for it.
  static InputState of(const std::filesystem::path& path);
  bool operator==(const InputState& other) const;
  /// False of a file that was written just before: a second writing may leave the same times.
  bool tells_changes() const { return tells_changes_; }

 private:
  std::shared_ptr<const std::string> text_;  ///< null: it is a file
  bool exists_ = false, tells_changes_ = true;
  dev_t device_ = 0;
  ino_t inode_ = 0;
  off_t size_ = 0;
  timespec modified_{}, changed_{};
};
/// Files that were looked at or for, by whole path, as they were.
using InputStates = std::map<std::filesystem::path, InputState>;
/// Whether reading them all would give what it gave.
bool are_unchanged(const InputStates& states);

/// While it lives, the functions of base/file take texts for files on this thread, and note what
/// they look at. Scopes may lie in each other: the inner one's notes are the outer one's too.
class InputScope {
 public:
  /// `texts`: null: as in the scope around. `states`: null: nothing is noted here. Both must
  /// outlive this.
  explicit InputScope(const TextOfFile* texts, InputStates* states = nullptr);
  ~InputScope();
  InputScope(const InputScope&) = delete;
  InputScope& operator=(const InputScope&) = delete;

  /// The text for the file at `path` on this thread; null: there is none.
  static std::shared_ptr<const std::string> text_of(const std::filesystem::path& path);
  /// Notes for the scopes of this thread that the file was looked at or for.
  static void note(const std::filesystem::path& path);
  /// Notes for the scopes of this thread what was noted before, where it is known anew.
  static void note(const InputStates& states);

 private:
  static inline thread_local const InputScope* current_ = nullptr;
  const InputScope* const outer_;
  const TextOfFile* texts_;
  InputStates* states_;
};

}  // namespace tessera
