#pragma once

#include <cstdint>
#include <vector>

#include "renderer/shapes/ray.h"
#include "renderer/shapes/triangle_mesh.h"

namespace tessera {

/// An edge that triangles pass in this direction once more than in the other: one of its neighbours
/// is missing, or lies the other way round. Numbers of vertices; of those at the same place the
/// first.
struct OpenEdge {
  uint32_t from = 0, to = 0;
  friend bool operator==(const OpenEdge&, const OpenEdge&) = default;
};

/// All of them, an edge as often as that is so; none where the mesh is closed.
std::vector<OpenEdge> open_edges(const TriangleMesh& mesh);

/// Moves each vertex to the first one within `distance` > 0 of it that is not moved itself, so that
/// they count as one. Triangles stay, also those whose corners now coincide.
void merge_vertices(TriangleMesh& mesh, double distance);

/// The edges at which a mesh is open, as a tree that tells how far the mesh goes around a point.
/// Immutable: any number of threads may ask at once.
class MeshBoundary {
 public:
  explicit MeshBoundary(const TriangleMesh& mesh);

  const std::vector<OpenEdge>& edges() const { return edges_; }
  /// The generalised winding number of the mesh about the origin of the ray (Jacobson, Kavan,
  /// Sorkine-Hornung, Robust Inside-Outside Segmentation using Generalized Winding Numbers, 2013):
  /// the share of all directions in which it is seen from inside less that in which it is seen from
  /// outside, a whole number where the mesh is closed. `crossing_number` is that of all its hits
  /// with the ray, whose direction makes no difference. Edges that are far away count as the
  /// dipoles that Barill et al., Fast Winding Numbers for Soups and Clouds, 2018, take for
  /// triangles, which is right to some hundredths.
  double winding_number(const Ray& ray, int crossing_number) const;
  /// Whether its size is above a half, which mostly shows without a close look at all holes.
  bool goes_around(const Ray& ray, int crossing_number) const;

 private:
  /// Below a node in preorder are parts of the same chain of edges, or whole loops.
  struct Node {
    Point3 center;
    double radius = 0;
    Vec3 area;             ///< of the loop that the chain and the edge back to its begin make
    double most_area = 0;  ///< of surfaces in the sphere that together close the loops
    uint32_t first = 0, last = 0;  ///< of the points of the chain; the same: loops
    uint32_t end = 0;              ///< one past the nodes below
    bool is_leaf = false;
  };
  struct Loop {
    uint32_t first = 0, last = 0;
    Point3 center;
  };
  std::vector<Loop> make_loops(const TriangleMesh& mesh);
  void build_loops(std::vector<Loop>& loops, size_t begin, size_t end);
  void build_chain(uint32_t first, uint32_t last);
  /// In steradians.
  struct Angle {
    double sum = 0;
    double missed = 0;  ///< an upper bound of what was left out of the sum
  };
  /// The sum of solid angles that winding_number() is made of. Chains and loops that fill little of
  /// the sphere are left out, as long as together they are at most `may_miss`.
  Angle angle(const Ray& ray, double may_miss) const;

  std::vector<OpenEdge> edges_;
  std::vector<Point3> points_;  ///< of loop after loop, the first of each once more at its end
  std::vector<Node> nodes_;
};

}  // namespace tessera
