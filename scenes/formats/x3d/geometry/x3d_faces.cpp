#include "scenes/formats/x3d/geometry/x3d_faces.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/plural.h"

namespace tessera {
namespace {

class FaceReader {
 public:
  FaceReader(const X3dNode& node, const X3dValues& values) : node_(node), values_(values) {
    if (const X3dNode* coord = node.child("coord")) out_.points = values.points(*coord);
    coordinates_ = out_.points.size() / 3;
  }

  X3dFaces read() {
    const std::string& type = node_.type;
    if (type == "IndexedFaceSet") {
      read_index("coordIndex");
      for_each_run([&](size_t begin, size_t end) { face(range(begin, end)); });
    } else if (type == "IndexedTriangleStripSet") {
      read_index("index");
      for_each_run([&](size_t begin, size_t end) { strip(begin, end); });
    } else if (type == "IndexedTriangleFanSet") {
      read_index("index");
      for_each_run([&](size_t begin, size_t end) { fan(begin, end); });
    } else if (type == "TriangleStripSet") {
      count_through();
      for_each_count("stripCount", [&](size_t begin, size_t end) { strip(begin, end); });
    } else if (type == "TriangleFanSet") {
      count_through();
      for_each_count("fanCount", [&](size_t begin, size_t end) { fan(begin, end); });
    } else {
      const size_t size = type == "QuadSet" || type == "IndexedQuadSet" ? 4 : 3;
      if (type.starts_with("Indexed"))
        read_index("index");
      else
        count_through();
      for (size_t at = 0; at + size <= index_.values.size(); at += size) face(range(at, at + size));
      if (const size_t rest = index_.values.size() % size)
        values_.repair(
            index_.offsets.back(),
            fmt::format("{} after the last face of {}", counted(rest, "corner"), describe(node_)),
            fmt::format("{} a face", size), "what is left over is left out");
    }
    if (dropped_)
      values_.warn(first_dropped_, "faces with fewer than 3 different points are left out",
                   dropped_);
    return std::move(out_);
  }

 private:
  void read_index(const char* name) {
    index_ = values_.integers(node_, name, X3dValues::kNoInteger, "the face is left out");
    field_ = name;
  }

  void count_through() {
    field_ = "coord";
    for (size_t i = 0; i < coordinates_; ++i) {
      index_.values.push_back(static_cast<int32_t>(i));
      index_.offsets.push_back(static_cast<uint32_t>(node_.offset));
    }
  }

  template <typename Action>
  void for_each_run(const Action& action) {
    size_t begin = 0;
    for (size_t at = 0; at <= index_.values.size(); ++at) {
      if (at < index_.values.size() && index_.values[at] != -1) continue;
      if (at > begin) action(begin, at);
      begin = at + 1;
    }
  }

  template <typename Action>
  void for_each_count(const char* name, const Action& action) {
    const std::vector<size_t> begins = values_.runs(node_, name, 3, coordinates_);
    for (size_t i = 0; i + 1 < begins.size(); ++i) action(begins[i], begins[i + 1]);
  }

  static std::vector<size_t> range(size_t begin, size_t end) {
    std::vector<size_t> slots;
    for (size_t at = begin; at < end; ++at) slots.push_back(at);
    return slots;
  }

  void strip(size_t begin, size_t end) {
    for (size_t at = begin; at + 2 < end; ++at) {
      const bool odd = (at - begin) % 2 != 0;
      face({at, at + (odd ? 2 : 1), at + (odd ? 1 : 2)});
    }
  }

  void fan(size_t begin, size_t end) {
    for (size_t at = begin + 1; at + 1 < end; ++at) face({begin, at, at + 1});
  }

  /// `slots` are places in the index.
  void face(const std::vector<size_t>& slots) {
    const uint32_t number = next_number_++;
    std::vector<uint32_t> points;
    for (const size_t slot : slots) {
      const auto point = coordinate(slot, number);
      if (!point) return;
      points.push_back(*point);
    }
    std::vector<uint32_t> different = points;
    std::sort(different.begin(), different.end());
    different.erase(std::unique(different.begin(), different.end()), different.end());
    if (different.size() < 3) {
      if (dropped_++ == 0) first_dropped_ = index_.offsets[slots[0]];
      return;
    }
    out_.add_face(points);
    out_.corner_slots.insert(out_.corner_slots.end(), slots.begin(), slots.end());
    out_.numbers.back() = number;
  }

  /// Nothing where there is no point.
  std::optional<uint32_t> coordinate(size_t slot, uint32_t number) const {
    const int32_t index = index_.values[slot];
    if (index == X3dValues::kNoInteger) return std::nullopt;
    if (index < 0 || static_cast<size_t>(index) >= coordinates_) {
      values_.repair(index_.offsets[slot],
                     fmt::format("{} {} in face {} of {}, which has {}", field_, index, number,
                                 describe(node_), counted(coordinates_, "point")),
                     "an index of a point", "the face is left out");
      return std::nullopt;
    }
    const float* const p = &out_.points[3 * static_cast<size_t>(index)];
    if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2])) return std::nullopt;
    return static_cast<uint32_t>(index);
  }

  const X3dNode& node_;
  const X3dValues& values_;
  size_t coordinates_ = 0;
  const char* field_ = "";
  X3dValues::Integers index_;
  X3dFaces out_;
  uint32_t next_number_ = 0;
  uint64_t dropped_ = 0;
  size_t first_dropped_ = 0;  ///< where it is written
};

}  // namespace

void X3dFaces::add_face(std::span<const uint32_t> face) {
  polygons.corners.insert(polygons.corners.end(), face.begin(), face.end());
  numbers.push_back(static_cast<uint32_t>(polygons.size()));
  polygons.starts.push_back(static_cast<uint32_t>(polygons.corners.size()));
}

X3dFaces read_x3d_polygons(const X3dNode& node, const X3dValues& values) {
  return FaceReader(node, values).read();
}

}  // namespace tessera
