#include "interpolate/volume/key_choice.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

#include "core/surfaces/geometry.h"

namespace keypose::interpolation {

namespace {

/// Sum over edges of the squared angle between the normals over the edge's share of area.
/// Independent of scale: about 4 pi for a ball, more for folded or twisted surfaces.
/// Source: hinge energy, Grinspun et al. 2003.
double BendingEnergy(const PointsX3& p, const FacesX3& faces) {
  struct Side {
    int low, high, face;
    bool operator<(const Side& o) const {
      return std::tie(low, high, face) < std::tie(o.low, o.high, o.face);
    }
  };
  std::vector<Side> sides;
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(faces(f, k), faces(f, (k + 1) % 3));
      sides.push_back({low, high, static_cast<int>(f)});
    }
  std::sort(sides.begin(), sides.end());
  const Eigen::VectorXd areas = FaceAreas(p, faces);
  const PointsX3 normals = FaceNormals(p, faces);
  double sum = 0;
  for (std::size_t s = 0; s + 1 < sides.size(); ++s) {
    if (sides[s].low != sides[s + 1].low || sides[s].high != sides[s + 1].high) continue;
    const int a = sides[s].face, b = sides[s + 1].face;
    const double edge = (p.row(sides[s].low) - p.row(sides[s].high)).squaredNorm();
    const double angle =
        2 * std::asin(std::min(1.0, 0.5 * (normals.row(a) - normals.row(b)).norm()));
    sum += angle * angle * edge /
           // bounded, so that a single sliver cannot dominate
           std::max(areas[a] + areas[b], 0.05 * edge);
  }
  return sum;
}

}  // namespace

bool SecondIsSmoother(const PointsX3& v, const PointsX3& u, const FacesX3& faces) {
  const double bend_v = BendingEnergy(v, faces), bend_u = BendingEnergy(u, faces);
  if (bend_v != bend_u) return bend_u < bend_v;
  return std::lexicographical_compare(u.data(), u.data() + u.size(), v.data(), v.data() + v.size());
}

}  // namespace keypose::interpolation
