#pragma once

#include <cstdint>
#include <vector>

#include "scenes/mesh/mesh_data.h"

namespace tessera {

/// No index.
inline constexpr uint32_t kNoIndex = 0xFFFFFFFF;

/// A corner of a face as modelling formats describe it: an index into each array of values.
struct MeshCorner {
  uint32_t position = kNoIndex;
  uint32_t normal = kNoIndex;
  uint32_t uv = kNoIndex;
  uint32_t color = kNoIndex;
  friend bool operator==(const MeshCorner&, const MeshCorner&) = default;
};

/// The different corners that faces use, numbered in the order of their first use: the vertices of
/// the mesh. Finding one takes time in the number of those at the same position.
class VertexTable {
 public:
  uint32_t add(const MeshCorner& corner);
  /// One that add() does not find again.
  uint32_t add_apart(const MeshCorner& corner);
  /// The first vertex at the same position with the same normal.
  uint32_t leader(uint32_t vertex) const;

  size_t size() const { return vertices_.size(); }
  const MeshCorner& operator[](size_t vertex) const { return vertices_[vertex].corner; }

  /// One value of `width` numbers a vertex from those of an array, 0 where a corner has no index;
  /// `member` says which index.
  std::vector<float> gather(const std::vector<float>& values, size_t width,
                            uint32_t MeshCorner::*member) const;
  bool any(uint32_t MeshCorner::*member) const;

 private:
  struct Vertex {
    MeshCorner corner;
    uint32_t next;  ///< the next vertex at the same position
  };

  std::vector<uint32_t> first_;  ///< by position
  std::vector<Vertex> vertices_;
};

}  // namespace tessera
