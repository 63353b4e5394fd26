#include <fmt/format.h>

#include <span>
#include <utility>

#include "base/plural.h"
#include "scenes/formats/x3d/geometry/x3d_faces.h"

namespace tessera {
namespace {

class LineBuilder {
 public:
  LineBuilder(const X3dNode& node, const X3dValues& values, const Pen& pen)
      : node_(node), values_(values), strokes_(pen) {
    if (const X3dNode* coord = node.child("coord")) coordinates_ = values.points(*coord);
  }

  X3dFaces make() {
    if (node_.type == "PointSet")
      for (size_t i = 0; i < coordinates_.size() / 3; ++i) add_point(i);
    else if (node_.type == "LineSet")
      add_counted();
    else
      add_indexed();
    out_.points = std::move(strokes_.positions);
    return std::move(out_);
  }

 private:
  Vec3 coordinate(size_t i) const {
    return {coordinates_[3 * i], coordinates_[3 * i + 1], coordinates_[3 * i + 2]};
  }

  void add_counted() {
    const std::vector<size_t> begins =
        values_.runs(node_, "vertexCount", 2, coordinates_.size() / 3);
    for (size_t k = 0; k + 1 < begins.size(); ++k)
      for (size_t i = begins[k]; i + 1 < begins[k + 1]; ++i) add_line(i, i + 1, k);
  }

  void add_indexed() {
    constexpr const char* kLeftOut = "the lines there are left out";
    const auto index = values_.integers(node_, "coordIndex", X3dValues::kNoInteger, kLeftOut);
    index_ = index.values;
    const size_t most = coordinates_.size() / 3;
    const auto is_point = [&](int32_t i) { return i >= 0 && static_cast<size_t>(i) < most; };
    size_t line = 0;
    for (size_t at = 0; at < index.values.size(); ++at) {
      if (index.values[at] == -1) {
        ++line;
        continue;
      }
      if (index.values[at] == X3dValues::kNoInteger) continue;
      if (!is_point(index.values[at]))
        values_.repair(index.offsets[at],
                       fmt::format("coordIndex {} of {}, which has {}", index.values[at],
                                   describe(node_), counted(most, "point")),
                       "an index of a point", kLeftOut);
      else if (at > 0 && is_point(index.values[at - 1]))
        add_line(at - 1, at, line);
    }
  }

  /// The coordinate at a place of the index, or without one of that number.
  size_t coordinate_at(size_t slot) const {
    return index_.empty() ? slot : static_cast<size_t>(index_[slot]);
  }

  PenStrokes::End end(size_t slot) const {
    return {coordinate(coordinate_at(slot)), static_cast<uint32_t>(slot)};
  }

  void add_point(size_t i) {
    strokes_.add_point(end(i));
    take_faces(i);
  }

  void add_line(size_t from_slot, size_t to_slot, size_t number) {
    strokes_.add_line(end(from_slot), end(to_slot));
    take_faces(number);
  }

  /// Adds what the strokes have more than before, which shows the line or point of that `number`.
  void take_faces(size_t number) {
    constexpr size_t kBytes = 64;  // a vertex, about, with the faces about it
    const size_t vertices = strokes_.sources.size();
    values_.spend((vertices - vertices_) * kBytes, node_.offset);
    vertices_ = vertices;
    if (vertices > kMaxX3dPoints)
      throw values_.document().error(node_.offset,
                                     fmt::format("too many lines in {}", describe(node_)),
                                     fmt::format("at most {} corners", kMaxX3dPoints));
    for (size_t face = out_.numbers.size(); face < strokes_.face_sizes.size(); ++face) {
      const std::span corners(&strokes_.corners[out_.corner_slots.size()],
                              strokes_.face_sizes[face]);
      for (const uint32_t corner : corners) {
        const uint32_t slot = strokes_.sources[corner];
        out_.corner_slots.push_back(slot);
        out_.corner_coordinates.push_back(static_cast<uint32_t>(coordinate_at(slot)));
      }
      out_.add_face(corners);
      out_.numbers.back() = static_cast<uint32_t>(number);
    }
  }

  const X3dNode& node_;
  const X3dValues& values_;
  std::vector<float> coordinates_;
  std::vector<int32_t> index_;  ///< of coordinates; empty: each once, in their order
  PenStrokes strokes_;          ///< the source of each vertex is its place in the index
  size_t vertices_ = 0;         ///< of the strokes that memory was counted for
  X3dFaces out_;
};

}  // namespace

X3dFaces read_x3d_lines(const X3dNode& node, const X3dValues& values, const Pen& pen) {
  return LineBuilder(node, values, pen).make();
}

}  // namespace tessera
