#pragma once

#include <sys/types.h>

#include <string>
#include <string_view>

#include "base/owned_descriptor.h"

namespace tessera {

/// A file that is being written under a name of its own, hidden, and gets its real one when it is
/// whole. Unless it is finished it goes away with this object. Functions throw render_error.
class NewFile {
 public:
  /// In the open folder `folder`, which it keeps; `shown` is what messages call the file.
  NewFile(OwnedDescriptor folder, std::string name, std::string shown, mode_t mode = 0666);
  ~NewFile();
  NewFile(NewFile&& other) noexcept;
  NewFile& operator=(NewFile&& other) = delete;

  void append(std::string_view bytes);
  /// Gives it its name, where none has that name yet.
  void finish();
  /// Gives it its name, in the place of any file of that name.
  void finish_over();
  /// Removes the file of that name in the open folder where a program that was killed had begun to
  /// write it; true where it did.
  static bool remove_unfinished(int folder, const std::string& name);
  int descriptor() const { return file_.get(); }

 private:
  void sync();
  [[noreturn]] void fail() const;

  OwnedDescriptor folder_;
  OwnedDescriptor file_;
  std::string name_, shown_;
  std::string unfinished_;  ///< its name until then; empty when it has the other
};

}  // namespace tessera
