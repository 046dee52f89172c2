#include "interpolate/closed_seams.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/surfaces/seams.h"
#include "core/values/size_of.h"

namespace keypose::interpolation {
namespace {

/// For each vertex the one that it is joined to, or itself.
std::vector<int> JoinedVertices(const std::vector<PointsX3>& keys, const FacesX3& faces) {
  Mesh first;
  first.points = keys[0];
  first.faces = faces;
  std::vector<int> one = FindSeams(first).one;
  if (one.empty()) {
    one.resize(static_cast<std::size_t>(keys[0].rows()));
    std::iota(one.begin(), one.end(), 0);
    return one;
  }
  for (int v = 0; v < SizeOf(one); ++v)
    for (const PointsX3& key : keys)
      if (key.row(v) != key.row(one[v])) one[v] = v;
  // No face may lose its area.
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = faces(f, k), b = faces(f, (k + 1) % 3);
      if (a != b && one[a] == one[b]) {
        one[a] = a;
        one[b] = b;
      }
    }
  return one;
}

}  // namespace

ClosedSeams::ClosedSeams(const std::vector<PointsX3>& keys, const FacesX3& faces) {
  const std::vector<int> one = JoinedVertices(keys, faces);
  of_given_.resize(one.size());
  for (int v = 0; v < SizeOf(one); ++v) {
    if (one[v] == v) kept_.push_back(v);
    // A vertex is joined to an earlier one.
    of_given_[v] = one[v] == v ? SizeOf(kept_) - 1 : of_given_[one[v]];
  }
  joined_ = SizeOf(one) - SizeOf(kept_);
  faces_ = faces.unaryExpr([&](int v) { return of_given_[v]; });
}

std::vector<PointsX3> ClosedSeams::Closed(std::vector<PointsX3> keys) const {
  if (joined_ > 0)
    for (PointsX3& key : keys) key = PointsX3(key(kept_, Eigen::all));
  return keys;
}

Rules ClosedSeams::Closed(Rules rules) const {
  for (HeldRegion& region : rules.held) {
    for (int& v : region.vertices) v = of_given_[v];
    std::sort(region.vertices.begin(), region.vertices.end());
    region.vertices.erase(std::unique(region.vertices.begin(), region.vertices.end()),
                          region.vertices.end());
  }
  return rules;
}

PointsX3 ClosedSeams::Opened(const PointsX3& frame) const {
  return joined_ > 0 ? PointsX3(frame(of_given_, Eigen::all)) : frame;
}

}  // namespace keypose::interpolation
