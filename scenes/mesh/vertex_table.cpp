#include "scenes/mesh/vertex_table.h"

#include <algorithm>
#include <cstddef>

namespace tessera {

uint32_t VertexTable::add(const MeshCorner& corner) {
  if (first_.size() <= corner.position) first_.resize(size_t{corner.position} + 1, kNoIndex);
  uint32_t* link = &first_[corner.position];
  while (*link != kNoIndex) {
    Vertex& known = vertices_[*link];
    if (known.corner == corner) return *link;
    link = &known.next;
  }
  *link = static_cast<uint32_t>(vertices_.size());
  return add_apart(corner);
}

uint32_t VertexTable::add_apart(const MeshCorner& corner) {
  vertices_.push_back({corner, kNoIndex});
  return static_cast<uint32_t>(vertices_.size() - 1);
}

uint32_t VertexTable::leader(uint32_t vertex) const {
  const MeshCorner& corner = vertices_[vertex].corner;
  uint32_t at = first_[corner.position];
  while (vertices_[at].corner.normal != corner.normal) at = vertices_[at].next;
  return at;
}

std::vector<float> VertexTable::gather(const std::vector<float>& values, size_t width,
                                       uint32_t MeshCorner::*member) const {
  std::vector<float> out(vertices_.size() * width, 0.f);
  for (size_t i = 0; i < vertices_.size(); ++i) {
    const uint32_t index = vertices_[i].corner.*member;
    if (index == kNoIndex) continue;
    std::copy_n(values.begin() + static_cast<ptrdiff_t>(index * width), width,
                out.begin() + static_cast<ptrdiff_t>(i * width));
  }
  return out;
}

bool VertexTable::any(uint32_t MeshCorner::*member) const {
  return std::any_of(vertices_.begin(), vertices_.end(),
                     [&](const Vertex& v) { return v.corner.*member != kNoIndex; });
}

}  // namespace tessera
