#include "cleanup/repair/see_through.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <set>

#include "cleanup/repair/handle_loops.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/size_of.h"

namespace keypose::cleanup {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// The winding number of a loop around a line, seen from the line's origin. 0 when a vertex of the
/// loop is behind the origin.
int Winding(const PointsX3& points, const std::vector<int>& loop, const SightLine& line) {
  const Vector3d along = line.direction.normalized(), right = along.unitOrthogonal(),
                 up = along.cross(right);
  const auto seen = [&](int v) {
    const Vector3d x = points.row(v).transpose() - line.origin;
    return Vector3d(x.dot(right), x.dot(up), x.dot(along));
  };
  int winding = 0;
  Vector3d a = seen(loop.back());
  for (const int v : loop) {
    const Vector3d b = seen(v);
    if (b[2] <= 0) return 0;
    // Perspective scales each vertex by a positive number, which does not change these signs.
    if ((a[1] <= 0) != (b[1] <= 0)) {
      const double side = a[0] * b[1] - b[0] * a[1];
      if (a[1] <= 0 && side > 0) ++winding;
      if (b[1] <= 0 && side < 0) --winding;
    }
    a = b;
  }
  return winding;
}

using Links = std::vector<int>;  // winding numbers of one line with all loops

int Rank(const std::set<Links>& rows) {
  if (rows.empty()) return 0;
  Eigen::MatrixXd matrix(std::ssize(rows), static_cast<Eigen::Index>(rows.begin()->size()));
  Eigen::Index r = 0;
  for (const Links& row : rows) {
    for (std::size_t c = 0; c < row.size(); ++c) matrix(r, static_cast<Eigen::Index>(c)) = row[c];
    ++r;
  }
  return static_cast<int>(matrix.fullPivLu().rank());
}

}  // namespace

int HandlesSeenThrough(const Mesh& closed, const std::vector<SightLine>& lines) {
  if (lines.empty()) return 0;
  const std::vector<std::vector<int>> loops = LoopBasis(closed);
  if (loops.empty()) return 0;
  const RayScene scene(closed.points, closed.faces);
  std::vector<Links> links(lines.size());
  const auto link = [&](std::int64_t i) {
    if (scene.Occluded(lines[i].origin, lines[i].direction, 0,
                       std::numeric_limits<double>::infinity()))
      return;
    Links found;
    for (const std::vector<int>& loop : loops)
      found.push_back(Winding(closed.points, loop, lines[i]));
    if (std::any_of(found.begin(), found.end(), [](int n) { return n != 0; }))
      links[i] = std::move(found);
  };
  ParallelFor(std::ssize(lines), link, 16);
  std::map<int, std::set<Links>> by_view;
  for (std::size_t i = 0; i < lines.size(); ++i)
    if (!links[i].empty()) by_view[lines[i].view].insert(links[i]);
  // A handle needs at least two views: the result is the smallest rank when any one view is left
  // out.
  int least = by_view.size() < 2 ? 0 : SizeOf(loops);
  for (const auto& [left_out, unused] : by_view) {
    std::set<Links> rows;
    for (const auto& [view, seen] : by_view)
      if (view != left_out) rows.insert(seen.begin(), seen.end());
    least = std::min(least, Rank(rows));
  }
  return least;
}

}  // namespace keypose::cleanup
