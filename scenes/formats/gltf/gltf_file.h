#pragma once

#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/formats/gltf/gltf_value.h"

namespace tessera {

/// The bytes of a file that a glTF file names by `uri`, already decoded to a relative path. Throws
/// scene_error, without a place, for what may not or can not be read.
using GltfFolder = std::function<std::string(const std::string& path)>;

/// A glTF 2.0 file's JSON and the bytes that it refers to (Khronos, glTF 2.0 specification, 3 and
/// 4).
class GltfFile {
 public:
  /// `bytes` are those of a .gltf or a .glb and have to outlive this.
  GltfFile(std::string_view bytes, const std::string& name, GltfFolder folder);
  GltfFile(const GltfFile&) = delete;
  GltfFile& operator=(const GltfFile&) = delete;
  ~GltfFile();

  GltfValue root();
  const std::string& name() const { return text_.name; }
  /// Of extensions: those that it says it uses, and those that are used in it all the same.
  std::vector<std::string> extension_names();
  /// What there is to say of the file.
  Warnings& warnings() { return text_.warnings; }
  /// An element of a top-level array, by an index that some value holds.
  GltfValue element(const char* array, size_t index) { return root()[array].at(index); }

  struct View {
    std::string_view bytes;
    size_t stride = 0;  ///< 0: tightly packed
    size_t begin = 0;   ///< the offset of the bytes in their buffer
  };
  /// Loads the buffer, or unpacks it, on its first use. Throws where that cannot be read.
  View view(size_t index);
  /// Rows that a compressed mesh has for an accessor, next to each other.
  struct Rows {
    std::string bytes;
    size_t count = 0;
    std::string source;  ///< names the rows and their mesh
  };
  void unpack(size_t accessor, Rows rows) { unpacked_[accessor] = std::move(rows); }
  /// Null: it has its own. Valid until the accessor is unpacked again.
  const Rows* unpacked(size_t accessor) const {
    const auto found = unpacked_.find(accessor);
    return found == unpacked_.end() ? nullptr : &found->second;
  }
  /// Calls `read`. Where that throws of what breaks the format, it warns of it and of what is
  /// `taken`, and returns false.
  template <typename Read>
  bool attempt(std::string_view taken, const Read& read) {
    try {
      read();
      return true;
    } catch (const Error& error) {
      if (spent_ > kMostRead || error.diagnostics().empty()) throw;
      keep_problem(error);
      warnings().repair(error, taken);
      return false;
    }
  }
  void keep_problem(const Error& error) {
    if (!problem_) problem_ = error;
  }
  /// The first that was kept: why a file is refused when nothing of it is left.
  const std::optional<Error>& problem() const { return problem_; }
  /// Counts what is read of the file: its parts may refer to each other again and again, so that a
  /// small file could ask for more than any machine has. Throws beyond kMostRead.
  void spend(uint64_t amount, const GltfValue& on);
  static constexpr uint64_t kMostRead = uint64_t{1} << 31;
  /// The bytes that a data: URI holds; nothing for another URI.
  static std::optional<std::string> data_of_uri(const GltfValue& uri);
  /// A relative URI as a path.
  static std::string path_of_uri(const GltfValue& uri);

 private:
  void read_container(std::string_view bytes);
  void parse();
  std::string without_endless_numbers() const;
  std::string_view buffer(size_t index);
  /// The bytes that `holder`, a buffer view or its compressed form, names.
  View part(const GltfValue& holder);
  std::string load(const GltfValue& uri);

  GltfText text_;
  std::string_view json_text_, binary_;
  std::string repaired_json_;  ///< what json_text_ is of where it is not the file's own
  GltfFolder folder_;
  std::unique_ptr<nlohmann::json> json_;
  std::vector<std::optional<std::string>> buffers_;
  std::map<size_t, std::string> unpacked_views_;
  std::map<size_t, Rows> unpacked_;       ///< by accessor
  std::map<size_t, Error> lost_buffers_;  ///< why they cannot be read
  uint64_t spent_ = 0;
  std::optional<Error> problem_;
};

}  // namespace tessera
