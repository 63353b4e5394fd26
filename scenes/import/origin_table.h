#pragma once

#include <google/protobuf/message.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "proto/tessera/v1/scene.pb.h"

namespace tessera {

/// Where something of a scene stands in the files that it was read from.
struct Origin {
  /// call: of a macro; turn: of a loop; use: of a prototype.
  enum class Kind : uint8_t { part, include, call, turn, use };
  static constexpr uint32_t kNowhere = 0xFFFFFFFF;

  Kind kind = Kind::part;
  uint32_t file = 0;  ///< into OriginTable::files()
  /// A byte of the text that describes it, counted behind a byte-order mark. kNowhere: of a file
  /// that holds a scene's message, `path` tells; else nothing does.
  uint32_t offset = kNowhere;
  uint32_t turn = 0;   ///< from 1
  uint32_t above = 0;  ///< the origin of what made it: call, turn, use; 0: none
  std::string path{};  ///< "nodes[3].shape.csg.operands[0]"
  friend bool operator==(const Origin&, const Origin&) = default;
};

/// The origins of a scene's nodes. While files are read and placed into each other, nodes and
/// includes carry numbers of origins, as fields that their messages do not know; settle() takes
/// them off, so that the scene is the same whether or not anyone asks where it comes from.
class OriginTable {
 public:
  /// The number of that file's name.
  uint32_t file(const std::string& name);
  /// Returns its number: from 1.
  uint32_t add(Origin origin);
  const Origin& at(uint32_t number) const { return origins_[number - 1]; }
  size_t size() const { return origins_.size(); }
  const std::vector<std::string>& files() const { return files_; }

  /// Numbers the nodes and includes that have no origin, of what was read from the file. `by_path`:
  /// the file holds the message itself.
  void add_missing(v1::Scene& scene, const std::string& file_name, bool by_path);
  /// Takes in the origins of a scene that becomes a part of this one's, and numbers it anew.
  void absorb(v1::Scene& scene, const OriginTable& of_scene);
  /// Takes the numbers off the nodes of the whole scene.
  void settle(v1::Scene& scene);
  /// By the number of a node (proto/wire/node_numbers.h), once settled; 0: not known.
  uint32_t of_node(uint32_t node) const {
    return node == 0 || node > of_nodes_.size() ? 0 : of_nodes_[node - 1];
  }

 private:
  std::vector<std::string> files_;
  std::unordered_map<std::string, uint32_t> file_numbers_;
  std::vector<Origin> origins_;
  std::vector<uint32_t> of_nodes_;
};

/// The number that a message carries; 0: none.
uint32_t origin_of(const google::protobuf::Message& message);
void set_origin(google::protobuf::Message& message, uint32_t number);

}  // namespace tessera
