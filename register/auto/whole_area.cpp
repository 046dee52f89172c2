#include "register/auto/whole_area.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/surfaces/geometry.h"
#include "deform/solvers/sparse_pattern.h"

namespace keypose::registration {

double WholeArea(const Mesh& mesh, double& filled) {
  std::vector<std::pair<int, int>> sides;
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      sides.push_back(std::minmax<int>({mesh.faces(f, k), mesh.faces(f, (k + 1) % 3)}));
  std::sort(sides.begin(), sides.end());
  std::vector<std::pair<int, int>> open;
  for (std::size_t s = 0; s < sides.size();) {
    std::size_t e = s;
    while (e < sides.size() && sides[e] == sides[s]) ++e;
    if (e - s == 1) open.push_back(sides[s]);
    s = e;
  }
  int loops = 0;
  const std::vector<int> loop = Components(mesh.vertex_count(), open, loops);
  std::vector<double> length(loops, 0);
  for (const auto& [a, b] : open)
    length[loop[a]] += (mesh.points.row(a) - mesh.points.row(b)).norm();
  double discs = 0;
  for (double l : length) discs += l * l / (4 * M_PI);
  const double area = SurfaceArea(mesh.points, mesh.faces);
  filled = discs / (area + discs);
  return area + discs;
}

}  // namespace keypose::registration
