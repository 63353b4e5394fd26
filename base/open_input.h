#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/owned_descriptor.h"

namespace tessera {

/// While it lives, this thread opens files for reading below these folders alone, and no hidden
/// ones there, wherever links lead by then: that a file was found inside before says nothing once a
/// link may have been put in its place. Of several the last made counts; they end in reverse order.
class InputRoots {
 public:
  /// Absolute and without links.
  explicit InputRoots(std::vector<std::filesystem::path> roots);
  ~InputRoots();
  InputRoots(const InputRoots&) = delete;
  InputRoots& operator=(const InputRoots&) = delete;

  /// Null: this thread may open any.
  static const InputRoots* of_this_thread() { return current_; }
  /// The file opened for reading below one of the folders; -1 and errno where it lies in none, or
  /// is hidden.
  OwnedDescriptor open(const std::string& path) const;

 private:
  static inline thread_local const InputRoots* current_ = nullptr;
  const InputRoots* const outer_ = current_;
  std::vector<std::filesystem::path> roots_;
};

/// Opens the regular file for reading. -1 and errno where that fails, or InputRoots forbids it.
OwnedDescriptor open_input(const std::string& path);

struct CloseInputFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using InputFile = std::unique_ptr<std::FILE, CloseInputFile>;
/// The same for reading piece by piece; null and errno where it fails.
InputFile open_input_file(const std::string& path);

}  // namespace tessera
