#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

/// Collects what an importer has to say, each thing once with the number of times it happened.
class Warnings {
 public:
  static constexpr size_t kMostEntries = 50;

  /// `what` is a phrase such as "map_Kd: textures are not read yet".
  void add(std::string_view what) { ++entry(what); }
  void add(std::string_view what, uint64_t times) { entry(what) += times; }

  /// "FILE: what (3 times)" for each, in the order of their first appearance, at most kMostEntries.
  std::vector<std::string> list(std::string_view file) const;

 private:
  uint64_t& entry(std::string_view what);

  std::vector<std::pair<std::string, uint64_t>> entries_;
  std::map<std::string, size_t, std::less<>> index_;
  uint64_t dropped_ = 0;
};

}  // namespace tessera
