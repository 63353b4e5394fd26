#include "renderer/accel/spatial_splits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "renderer/accel/binning.h"

namespace tessera {
namespace {

using namespace binning;

constexpr double kLeastArea = 0x1p-8;  // of a triangle, in squares of the extent: see the header
constexpr double kLeastWaste = 3.5;    // half a box's surface to its triangle; 2: along the axes
constexpr double kSameDirection = 0x1p-11;  // sine between a triangle's normal and its class's
constexpr double kGrazing = 0x1p-9;         // and this minus that is above 2^-10
constexpr size_t kMostClasses = 64;

float centroid(const BuildBox& b, int axis) { return 0.5f * b.low[axis] + 0.5f * b.high[axis]; }

double half_area(const BuildBox& b) { return Box{b.low, b.high}.half_area(); }

/// Triangles of nearly one direction.
struct DirectionClass {
  Vec3 normal;
  double area = 0;
  std::vector<uint32_t> triangles;
};

/// Those of the largest triangles that waste the most of their boxes.
std::vector<DirectionClass> classes_to_cut(const TriangleMesh& mesh,
                                           const std::vector<BuildBox>& boxes, double extent) {
  std::vector<DirectionClass> classes;
  const double least = kLeastArea * extent * extent;
  for (uint32_t i = 0; i < boxes.size(); ++i) {
    if (half_area(boxes[i]) < kLeastWaste * least) continue;
    const auto [a, b, c] = mesh.corners(i);
    const Vec3 normal = cross(b - a, c - a);
    const double area = 0.5 * length(normal);
    if (!(area >= least && half_area(boxes[i]) >= kLeastWaste * area)) continue;
    const Vec3 unit = normal / (2 * area);
    auto at = std::find_if(classes.begin(), classes.end(), [&](const DirectionClass& known) {
      return length(cross(unit, known.normal)) <= kSameDirection;
    });
    if (at == classes.end()) {
      if (classes.size() == kMostClasses) continue;
      classes.push_back({unit, 0, {}});
      at = classes.end() - 1;
    }
    at->area += area;
    at->triangles.push_back(i);
  }
  std::stable_sort(
      classes.begin(), classes.end(),
      [](const DirectionClass& a, const DirectionClass& b) { return a.area > b.area; });
  if (classes.size() > CutPlanes::kMost) classes.resize(CutPlanes::kMost);
  return classes;
}

struct Polygon {
  std::array<double, 3> at[9];  // each of six planes adds at most one corner to three
  size_t size = 0;
  void add(const std::array<double, 3>& p) { at[size++] = p; }

  /// What is left on one side of a plane (Sutherland and Hodgman 1974).
  Polygon clipped(size_t axis, double plane, double side) const {
    Polygon to;
    for (size_t i = 0; i < size; ++i) {
      const auto &p = at[i], &q = at[(i + 1) % size];
      const double a = (p[axis] - plane) * side, b = (q[axis] - plane) * side;
      if (a >= 0) to.add(p);
      if ((a > 0 && b < 0) || (a < 0 && b > 0)) {
        std::array<double, 3> crossing;
        for (size_t k = 0; k < 3; ++k) crossing[k] = p[k] + (q[k] - p[k]) * (a / (a - b));
        crossing[axis] = plane;
        to.add(crossing);
      }
    }
    return to;
  }
};

/// The box of the triangle's part inside of `within`, rounded outward; nothing where there is none.
std::optional<BuildBox> box_of_part(const TriangleMesh& mesh, const BuildBox& within) {
  Polygon polygon;
  for (const Point3& p : mesh.corners(within.index())) polygon.add({p.x, p.y, p.z});
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<size_t>(a);
    polygon = polygon.clipped(axis, within.low[a], 1).clipped(axis, within.high[a], -1);
  }
  if (polygon.size == 0) return std::nullopt;
  Bounds3 bounds;
  for (size_t i = 0; i < polygon.size; ++i)
    bounds.extend(Point3{polygon.at[i][0], polygon.at[i][1], polygon.at[i][2]});
  BuildBox part(bounds, within.index());
  part.low = lane_max(part.low, within.low);
  part.high = lane_min(part.high, within.high);
  part.set_index(within.index());
  return part;
}

constexpr int kCutBins = 32;
constexpr size_t kFewest = 8;         // of these a leaf or two is made whatever the overlap
constexpr int kMaxCutDepth = 48;      // cuts end here, so that equal boxes cannot go on for ever
constexpr double kMinOverlap = 1e-5;  // of the whole's area: less is not worth a second reference

/// What is cut: triangles of few directions.
struct Pieces {
  const TriangleMesh& mesh;
  std::vector<bool> cuttable;

  bool can_cut(const BuildBox& b) const { return cuttable[b.index()]; }
  /// The box of what lies between two planes across an axis of a triangle's piece.
  BuildBox between(const BuildBox& whole, int axis, float low, float high) const {
    BuildBox part = whole;
    part.low[axis] = std::max(whole.low[axis], low);
    part.high[axis] = std::min(whole.high[axis], high);
    part.set_index(whole.index());
    return box_of_part(mesh, part).value_or(part);
  }
};

/// A plane and what it costs to cut there, as Split::cost.
struct Cut {
  double cost = kInf;
  int axis = -1;
  float at = 0;
};

bool is_sound(const Box& b) {
  return b.low[0] <= b.high[0] && b.low[1] <= b.high[1] && b.low[2] <= b.high[2];
}

double overlap(const Box& a, const Box& b) {
  const Box common{lane_max(a.low, b.low), lane_min(a.high, b.high)};
  return is_sound(common) ? common.half_area() : 0;
}

uint32_t blocks(size_t count) { return static_cast<uint32_t>((count + 3) / 4); }

/// The boxes of a node in slices across one axis: each slice's share of their space, and how many
/// begin and end in it.
class Slices {
 public:
  Slices(const Pieces& pieces, const std::vector<BuildBox>& boxes, const Box& whole, int axis)
      : axis_(axis), low_(whole.low[axis]), step_((whole.high[axis] - low_) / kCutBins) {
    for (Box& box : box_) box = Box::empty();
    if (!(step_ > 0 && step_ < kInf)) return;
    for (const BuildBox& b : boxes) {
      int first = slice(b.low[axis]), last = std::max(first, slice(b.high[axis]));
      if (!pieces.can_cut(b)) first = last = slice(centroid(b, axis));
      ++begins_[static_cast<size_t>(first)];
      ++ends_[static_cast<size_t>(last)];
      if (first == last) box_[static_cast<size_t>(first)].extend(b.low, b.high);
      for (int s = first; first < last && s <= last; ++s) {
        const BuildBox part = pieces.between(b, axis, s == first ? b.low[axis] : plane(s),
                                             s == last ? b.high[axis] : plane(s + 1));
        box_[static_cast<size_t>(s)].extend(part.low, part.high);
      }
    }
  }

  void best(Cut& cut) const {
    if (!(step_ > 0 && step_ < kInf)) return;
    std::array<double, kCutBins> right{};
    Box box = Box::empty();
    size_t count = 0;
    for (size_t s = kCutBins - 1; s > 0; --s) {
      box.extend(box_[s]);
      count += ends_[s];
      right[s] = count == 0 ? kInf : box.half_area() * blocks(count);
    }
    box = Box::empty();
    count = 0;
    for (size_t s = 1; s < kCutBins; ++s) {
      box.extend(box_[s - 1]);
      count += begins_[s - 1];
      if (count == 0) continue;
      const double cost = box.half_area() * blocks(count) + right[s];
      if (cost < cut.cost) cut = {cost, axis_, plane(static_cast<int>(s))};
    }
  }

 private:
  float plane(int s) const { return low_ + static_cast<float>(s) * step_; }
  int slice(float v) const {
    // 0 for what is not a number.
    return static_cast<int>(std::min(std::max(0.0f, (v - low_) / step_), kCutBins - 1.0f));
  }

  int axis_;
  float low_, step_;
  Box box_[kCutBins];
  size_t begins_[kCutBins] = {}, ends_[kCutBins] = {};
};

/// The two sides of a node.
struct Sides {
  std::vector<BuildBox> left, right;
  Box left_box = Box::empty(), right_box = Box::empty();

  void add_left(const BuildBox& b) { left.push_back(b), left_box.extend(b.low, b.high); }
  void add_right(const BuildBox& b) { right.push_back(b), right_box.extend(b.low, b.high); }
};

Sides divide(const std::vector<BuildBox>& boxes, const Binning& binning, const Split& split) {
  Sides sides;
  for (const BuildBox& b : boxes) {
    if (binning.is_below(b, split.axis, split.bin))
      sides.add_left(b);
    else
      sides.add_right(b);
  }
  return sides;
}

/// Puts what straddles the plane on both sides in pieces, or whole on one where that costs no more.
Sides divide(const Pieces& pieces, const std::vector<BuildBox>& boxes, const Cut& cut) {
  Sides sides;
  std::vector<BuildBox> astride;
  for (const BuildBox& b : boxes) {
    const bool whole = !pieces.can_cut(b);
    if (whole ? centroid(b, cut.axis) < cut.at : b.high[cut.axis] <= cut.at)
      sides.add_left(b);
    else if (whole || b.low[cut.axis] >= cut.at)
      sides.add_right(b);
    else
      astride.push_back(b);
  }
  auto left_count = static_cast<double>(sides.left.size() + astride.size());
  auto right_count = static_cast<double>(sides.right.size() + astride.size());
  for (const BuildBox& b : astride) {
    const BuildBox low = pieces.between(b, cut.axis, b.low[cut.axis], cut.at);
    const BuildBox high = pieces.between(b, cut.axis, cut.at, b.high[cut.axis]);
    const auto grown = [](Box box, const BuildBox& by) {
      box.extend(by.low, by.high);
      return box.half_area();
    };
    const double left_part = grown(sides.left_box, low), right_part = grown(sides.right_box, high);
    const double both = left_part * left_count + right_part * right_count;
    const double on_left =
        grown(sides.left_box, b) * left_count + sides.right_box.half_area() * (right_count - 1);
    const double on_right =
        sides.left_box.half_area() * (left_count - 1) + grown(sides.right_box, b) * right_count;
    if (on_left <= both && on_left <= on_right && !sides.right.empty()) {
      sides.add_left(b);
      --right_count;
    } else if (on_right <= both && !sides.left.empty()) {
      sides.add_right(b);
      --left_count;
    } else {
      sides.add_left(low);
      sides.add_right(high);
    }
  }
  return sides;
}

class Cutter {
 public:
  Cutter(const Pieces& pieces, double whole_area) : pieces_(pieces), whole_area_(whole_area) {}

  /// `spare`: how many more boxes than there are may come out.
  std::vector<BuildBox> cut(std::vector<BuildBox> boxes, size_t spare, int depth) const {
    if (boxes.size() < kFewest || spare == 0 || depth >= kMaxCutDepth) return boxes;
    if (std::none_of(boxes.begin(), boxes.end(),
                     [&](const BuildBox& b) { return pieces_.can_cut(b); }))
      return boxes;
    const Range range = make_range(boxes.data(), 0, boxes.size());
    if (range.box.half_area() <= kMinOverlap * whole_area_) return boxes;
    Sides sides;
    if (!find_sides(boxes, range, spare, sides)) return boxes;
    spare -= sides.left.size() + sides.right.size() - boxes.size();
    boxes = {};
    // In proportion, whoever comes first.
    const size_t total = sides.left.size() + sides.right.size();
    const auto left_spare =
        static_cast<size_t>(static_cast<double>(spare) * static_cast<double>(sides.left.size()) /
                            static_cast<double>(total));
    const size_t right_spare = spare - left_spare;
    std::vector<BuildBox> left = cut(std::move(sides.left), left_spare, depth + 1);
    boxes = cut(std::move(sides.right), right_spare, depth + 1);
    left.insert(left.end(), boxes.begin(), boxes.end());
    return left;
  }

 private:
  /// Divides by whole boxes, or by a plane where that is cheaper. False: not at all.
  bool find_sides(const std::vector<BuildBox>& boxes, const Range& range, size_t spare,
                  Sides& sides) const {
    const Binning binning(range);
    Split split;
    if (binning.usable[0] || binning.usable[1] || binning.usable[2]) {
      Bins bins(binning.bins);
      bins.add(binning, boxes.data(), 0, boxes.size());
      split = bins.best(binning, 2);
    }
    if (split.axis >= 0) {
      sides = divide(boxes, binning, split);
      if (overlap(sides.left_box, sides.right_box) <= kMinOverlap * whole_area_) return true;
    }
    Cut cut;
    for (int axis = 0; axis < 3; ++axis) Slices(pieces_, boxes, range.box, axis).best(cut);
    if (cut.axis >= 0 && cut.cost < split.cost) {
      Sides cut_sides = divide(pieces_, boxes, cut);
      const size_t more = cut_sides.left.size() + cut_sides.right.size() - boxes.size();
      const bool advances =
          cut_sides.left.size() < boxes.size() || cut_sides.right.size() < boxes.size();
      if (more <= spare && advances && !cut_sides.left.empty() && !cut_sides.right.empty()) {
        sides = std::move(cut_sides);
        return true;
      }
    }
    return split.axis >= 0;
  }

  const Pieces& pieces_;
  double whole_area_;
};

}  // namespace

bool CutPlanes::must_visit_all(const Ray& ray, double extent) const {
  const Vec3& d = ray.direction;
  const auto largest = [](double x, double y, double z) {
    return std::max({std::abs(x), std::abs(y), std::abs(z)});
  };
  // No more than sqrt(3) too large, and neither overflows nor vanishes as the length might.
  const double limit = kGrazing * 1.75 * largest(d.x, d.y, d.z);
  bool clears = true;
  for (int i = 0; i < kMost; ++i)
    clears &= std::abs(normal[0][i] * d.x + normal[1][i] * d.y + normal[2][i] * d.z) > limit;
  return !(clears && largest(ray.origin.x, ray.origin.y, ray.origin.z) <= 4 * extent &&
           ray.t_min >= 0);
}

SpatialSplits split_spatially(const TriangleMesh& mesh, std::vector<BuildBox> boxes) {
  SpatialSplits cuts{std::move(boxes), {}};
  const Box whole = binning::make_range(cuts.boxes.data(), 0, cuts.boxes.size()).box;
  double extent = 0;
  for (int a = 0; a < 3; ++a)
    extent = std::max({extent, std::abs(double{whole.low[a]}), std::abs(double{whole.high[a]})});
  const auto classes = classes_to_cut(mesh, cuts.boxes, extent);
  Pieces pieces{mesh, std::vector<bool>(cuts.boxes.size(), false)};
  for (const DirectionClass& one : classes) {
    for (int i = cuts.planes.count; i < CutPlanes::kMost; ++i)
      for (int a = 0; a < 3; ++a) cuts.planes.normal[a][i] = one.normal[a];
    ++cuts.planes.count;
    for (const uint32_t i : one.triangles) pieces.cuttable[i] = true;
  }
  if (cuts.planes.count == 0) return cuts;
  const auto spare = static_cast<size_t>(static_cast<double>(cuts.boxes.size()) * (kMaxGrowth - 1));
  cuts.boxes = Cutter(pieces, whole.half_area()).cut(std::move(cuts.boxes), spare, 0);
  return cuts;
}

}  // namespace tessera
