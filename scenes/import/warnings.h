#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "scenes/import/loaded_scene.h"

namespace tessera {

/// Adds one warning about a whole file.
void add_warning(LoadedScene& loaded, const std::string& file, const std::string& what);

/// Collects what an importer has to say, each thing once with the number of times it happened and,
/// where that is known, the place where it first did.
class Warnings {
 public:
  static constexpr size_t kMostEntries = 50;  ///< of add()
  /// Of all together. More can only come of a file that was made to be so, as a rule may have a
  /// number of the file in it.
  static constexpr size_t kMostInAll = 1000;
  /// Finds a place, which may take time; asked once for each thing.
  using Where = std::function<SourcePlace()>;

  /// `what` is a phrase such as "map_Kd: textures are not read yet".
  void add(std::string_view what, uint64_t times = 1) { add(what, nullptr, times); }
  void add(std::string_view what, const Where& where, uint64_t times = 1);
  /// Says that a value breaks a rule of its format, as what other programs export does now and
  /// then, and what is taken in its place: "FILE:LINE:COLUMN: PATH: FOUND; expected EXPECTED;
  /// TAKEN". Every such value passes here, so that a strict reading may refuse what this lists in
  /// LoadedScene::repairs. Values of the same name, the last in `path` that is no number, that
  /// break the same rule are one warning.
  void repair(std::string_view found, std::string_view expected, std::string_view taken,
              const Where& where, std::string_view path = {});
  /// The same of an error that has one place.
  void repair(const Error& error, std::string_view taken);

  /// Says of something that the file names and that is not there, as a picture, that it is done
  /// without; a strict reading refuses that too.
  void missing(std::string_view what, const Where& where);

  /// "FILE:LINE:COLUMN: what (3 times)" for each, in the order of their first appearance; "FILE:
  /// what" where no place is known. One line more tells how many are left out.
  std::vector<std::string> list(const std::string& file) const;
  /// Adds that list, and the parts of each of its lines, to what the file became.
  void add_to(LoadedScene& loaded, const std::string& file) const;

 private:
  struct Entry {
    std::string what;
    SourcePlace place;  ///< of an empty file: not known
    uint64_t count = 0;
    std::optional<Diagnostic> repair;  ///< the error that it would be
  };

  std::vector<Entry> entries_;
  std::map<std::string, size_t, std::less<>> index_;
  uint64_t dropped_ = 0;
};

}  // namespace tessera
