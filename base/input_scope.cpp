#include "base/input_scope.h"

#include <algorithm>
#include <cstdint>
#include <ctime>
#include <system_error>

namespace tessera {
namespace {

namespace fs = std::filesystem;

/// As a caller of TextOfFile knows it. Empty where there cannot be such a file.
fs::path whole(const fs::path& path) {
  std::error_code failure;
  const fs::path absolute = fs::absolute(path, failure);
  if (failure) return {};
  fs::path result = fs::weakly_canonical(absolute, failure);
  return failure ? fs::path() : result;
}

bool equal(const timespec& a, const timespec& b) {
  return a.tv_sec == b.tv_sec && a.tv_nsec == b.tv_nsec;
}

}  // namespace

InputState InputState::of(const fs::path& path) {
  InputState state;
  state.text_ = InputScope::text_of(path);
  struct stat status {};
  if (state.text_ || stat(path.c_str(), &status) != 0) return state;
  state.exists_ = true;
  state.device_ = status.st_dev;
  state.inode_ = status.st_ino;
  state.size_ = status.st_size;
  state.modified_ = status.st_mtim;
  state.changed_ = status.st_ctim;
  constexpr int64_t kCoarsestTick = 20'000'000;  // of file systems' clocks, in nanoseconds
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  const int64_t age = (int64_t{now.tv_sec} - status.st_mtim.tv_sec) * 1'000'000'000 +
                      (int64_t{now.tv_nsec} - status.st_mtim.tv_nsec);
  state.tells_changes_ = age < 0 || age > kCoarsestTick;
  return state;
}

bool InputState::operator==(const InputState& other) const {
  if (text_ || other.text_) {
    return text_ && other.text_ && (text_ == other.text_ || *text_ == *other.text_);
  }
  return exists_ == other.exists_ && device_ == other.device_ && inode_ == other.inode_ &&
         size_ == other.size_ && equal(modified_, other.modified_) &&
         equal(changed_, other.changed_);
}

bool are_unchanged(const InputStates& states) {
  return std::ranges::all_of(states, [](const auto& entry) {
    return entry.second.tells_changes() && InputState::of(entry.first) == entry.second;
  });
}

InputScope::InputScope(const TextOfFile* texts, InputStates* states)
    : outer_(current_), texts_(texts), states_(states) {
  current_ = this;
}

InputScope::~InputScope() { current_ = outer_; }

std::shared_ptr<const std::string> InputScope::text_of(const fs::path& path) {
  const InputScope* scope = current_;
  while (scope && !(scope->texts_ && *scope->texts_)) scope = scope->outer_;
  if (!scope) return nullptr;
  const fs::path known = whole(path);
  return known.empty() ? nullptr : (*scope->texts_)(known);
}

void InputScope::note(const fs::path& path) {
  const auto wants_notes = [] {
    for (const InputScope* scope = current_; scope; scope = scope->outer_) {
      if (scope->states_) return true;
    }
    return false;
  };
  if (!wants_notes()) return;
  std::error_code failure;
  const fs::path absolute = fs::absolute(path, failure);
  if (!failure) note({{absolute, InputState::of(absolute)}});
}

void InputScope::note(const InputStates& states) {
  // What was seen first is what the reader had, should the file change meanwhile.
  for (const InputScope* scope = current_; scope; scope = scope->outer_) {
    if (scope->states_) scope->states_->insert(states.begin(), states.end());
  }
}

}  // namespace tessera
