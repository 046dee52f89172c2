#include "core/testing/cut_in_charts.h"

#include <map>
#include <utility>

#include "core/values/size_of.h"

namespace keypose {

Mesh CutInCharts(const Mesh& whole, double z, std::vector<int>* origin) {
  Mesh cut;
  cut.faces = whole.faces;
  std::vector<int> of;
  std::map<std::pair<bool, int>, int> own;  // chart and vertex -> vertex
  for (Eigen::Index f = 0; f < cut.faces.rows(); ++f) {
    double middle = 0;
    for (int k = 0; k < 3; ++k) middle += whole.points(whole.faces(f, k), 2) / 3;
    for (int k = 0; k < 3; ++k) {
      const auto [at, is_new] = own.try_emplace({middle > z, cut.faces(f, k)}, SizeOf(of));
      if (is_new) of.push_back(cut.faces(f, k));
      cut.faces(f, k) = at->second;
    }
  }
  cut.points = whole.points(of, Eigen::all);
  if (origin) *origin = std::move(of);
  return cut;
}

}  // namespace keypose
