#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "studio/files/folder.h"
#include "studio/files/new_file.h"

namespace tessera {

/// Files that pages send in pieces. Each is new, and appears in the folder once it is whole; one
/// that is given up leaves nothing. Not thread-safe. Functions throw render_error; the upload that
/// they were about is given up then.
class Uploads {
 public:
  static constexpr uint64_t kMostBytes = uint64_t{256} << 20;
  /// Of one owner at once.
  static constexpr size_t kMostOpen = 4;

  /// The folder must outlive this.
  explicit Uploads(const Folder& folder) : folder_(folder) {}

  /// Begins a file of that name, or of one with a number where that is taken. `owner` and `number`
  /// tell uploads apart.
  void begin(uint64_t owner, uint32_t number, const std::string& name, uint64_t size);
  struct State {
    std::string name;  ///< that the file gets
    uint64_t received = 0;
    bool is_whole = false;  ///< then the file is there
  };
  State append(uint64_t owner, uint32_t number, std::string_view bytes, bool is_last);
  /// Gives up all uploads of that owner.
  void drop(uint64_t owner);

 private:
  struct Upload {
    NewFile file;
    std::string name;
    uint64_t size = 0, received = 0;
  };
  const Folder& folder_;
  std::map<std::pair<uint64_t, uint32_t>, Upload> open_;
};

}  // namespace tessera
