#include "cleanup/repair/components.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/size_of.h"
#include "core/values/union_find.h"

namespace keypose::cleanup {
namespace {

// Pieces that are not kept yet, but have a face or vertex within `gap` of the kept ones. Uses two
// scenes for all pieces together, because a scene is expensive and broken meshes have thousands of
// pieces.
std::vector<int> Touching(const Mesh& mesh, const Pieces& pieces, const std::vector<char>& keep,
                          double gap) {
  std::vector<char> other(keep.size());
  for (std::size_t i = 0; i < keep.size(); ++i) other[i] = !keep[i];
  std::vector<int> piece_of_rest_face;
  for (int f = 0; f < mesh.face_count(); ++f)
    if (!keep[pieces.of_face[f]]) piece_of_rest_face.push_back(pieces.of_face[f]);
  const Mesh near = KeptPieces(mesh, pieces, keep), rest = KeptPieces(mesh, pieces, other);
  const RayScene near_scene(near.points, near.faces), rest_scene(rest.points, rest.faces);
  std::set<int> found;
  for (int f = 0; f < rest.face_count(); ++f)
    for (int k = 0; k < 3 && !found.count(piece_of_rest_face[f]); ++k)
      if (near_scene.ClosestPoint(rest.points.row(rest.faces(f, k)).transpose(), gap).face >= 0)
        found.insert(piece_of_rest_face[f]);
  for (int v = 0; v < near.vertex_count(); ++v) {
    const int face = rest_scene.ClosestPoint(near.points.row(v).transpose(), gap).face;
    if (face >= 0) found.insert(piece_of_rest_face[face]);
  }
  return {found.begin(), found.end()};
}

int LargestByArea(const Pieces& pieces) {
  int best = 0;
  for (int i = 1; i < std::ssize(pieces.list); ++i)
    if (pieces.list[i].area > pieces.list[best].area) best = i;
  return best;
}

int CountDropped(const std::vector<char>& keep) {
  return static_cast<int>(std::count(keep.begin(), keep.end(), 0));
}

}  // namespace

Pieces FindPieces(const Mesh& mesh) {
  UnionFind joined(mesh.vertex_count());
  for (int f = 0; f < mesh.face_count(); ++f) {
    joined.Join(mesh.faces(f, 0), mesh.faces(f, 1));
    joined.Join(mesh.faces(f, 1), mesh.faces(f, 2));
  }
  Pieces pieces;
  pieces.of_face.resize(mesh.face_count());
  std::vector<int> id(mesh.vertex_count(), -1);
  const Eigen::Vector3d origin = mesh.points.colwise().mean();
  for (int f = 0; f < mesh.face_count(); ++f) {
    int& piece = id[joined.Find(mesh.faces(f, 0))];
    if (piece < 0) {
      piece = SizeOf(pieces.list);
      pieces.list.emplace_back();
    }
    pieces.of_face[f] = piece;
    const Eigen::Vector3d a = mesh.points.row(mesh.faces(f, 0)).transpose() - origin,
                          b = mesh.points.row(mesh.faces(f, 1)).transpose() - origin,
                          c = mesh.points.row(mesh.faces(f, 2)).transpose() - origin;
    Piece& p = pieces.list[piece];
    ++p.faces;
    p.area += (b - a).cross(c - a).norm() / 2;
    p.volume += a.dot(b.cross(c)) / 6;
  }
  return pieces;
}

Mesh KeptPieces(const Mesh& mesh, const Pieces& pieces, const std::vector<char>& keep) {
  std::vector<int> id(mesh.vertex_count(), -1);
  int face_count = 0;
  for (int f = 0; f < mesh.face_count(); ++f) {
    if (!keep[pieces.of_face[f]]) continue;
    ++face_count;
    for (int k = 0; k < 3; ++k) id[mesh.faces(f, k)] = 0;
  }
  Mesh out;
  int vertex_count = 0;
  for (int& i : id)
    if (i == 0) i = vertex_count++;
  out.points.resize(vertex_count, 3);
  out.faces.resize(face_count, 3);
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (id[v] >= 0) out.points.row(id[v]) = mesh.points.row(v);
  int at = 0;
  for (int f = 0; f < mesh.face_count(); ++f) {
    if (!keep[pieces.of_face[f]]) continue;
    for (int k = 0; k < 3; ++k) out.faces(at, k) = id[mesh.faces(f, k)];
    ++at;
  }
  return out;
}

Mesh WithoutBits(const Mesh& mesh, double min_share, int* removed) {
  const Pieces pieces = FindPieces(mesh);
  const double least = min_share * pieces.list[LargestByArea(pieces)].area;
  std::vector<char> keep;
  for (const Piece& piece : pieces.list) keep.push_back(piece.area >= least);
  *removed += CountDropped(keep);
  return KeptPieces(mesh, pieces, keep);
}

Mesh WithTouchingPieces(const Mesh& mesh, double gap, int* removed) {
  const Pieces pieces = FindPieces(mesh);
  const int count = SizeOf(pieces.list);
  if (count == 1) return mesh;
  std::vector<char> keep(count, 0);
  keep[LargestByArea(pieces)] = 1;
  while (CountDropped(keep) > 0) {
    const std::vector<int> found = Touching(mesh, pieces, keep, gap);
    if (found.empty()) break;
    for (const int piece : found) keep[piece] = 1;
  }
  *removed += CountDropped(keep);
  return KeptPieces(mesh, pieces, keep);
}

Mesh LargestPieces(const Mesh& closed, int count, int* removed) {
  const Pieces pieces = FindPieces(closed);
  if (count == 0 || SizeOf(pieces.list) <= count) return closed;
  std::vector<int> order(pieces.list.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return std::abs(pieces.list[a].volume) > std::abs(pieces.list[b].volume);
  });
  std::vector<char> keep(order.size(), 0);
  for (int i = 0; i < count; ++i) keep[order[i]] = 1;
  *removed += CountDropped(keep);
  return KeptPieces(closed, pieces, keep);
}

void OrientOutward(Mesh& closed) {
  const Pieces pieces = FindPieces(closed);
  for (int f = 0; f < closed.face_count(); ++f)
    if (pieces.list[pieces.of_face[f]].volume < 0)
      std::swap(closed.faces(f, 1), closed.faces(f, 2));
}

}  // namespace keypose::cleanup
