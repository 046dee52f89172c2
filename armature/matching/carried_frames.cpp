#include "armature/matching/carried_frames.h"

#include <algorithm>

#include "core/values/size_of.h"

namespace keypose::armature {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::Vector4d;

std::vector<Quaterniond> TurnsAlong(const Polyline& curve, const std::vector<Quaterniond>& turns,
                                    const Eigen::VectorXd& lengths) {
  // The same rotation has two quaternions. Along the chain neighbours take the nearer ones.
  std::vector<Vector4d> near = {turns[0].coeffs()};
  for (int p = 1; p < SizeOf(turns); ++p) {
    const Vector4d next = turns[p].coeffs();
    near.push_back(near.back().dot(next) < 0 ? Vector4d(-next) : next);
  }
  const double share = curve.length() / lengths.sum();
  std::vector<Quaterniond> result;
  double begin = 0;
  int first = 0;
  for (Eigen::Index i = 0; i < lengths.size(); ++i) {
    const double end = begin + share * lengths[i];
    Vector4d sum = Vector4d::Zero();
    double nothing = 1e-12 * curve.length();  // overlaps by rounding
    while (first + 1 < SizeOf(near) && curve.ends()[first + 1] <= begin) ++first;
    for (int p = first; p < SizeOf(near) && curve.ends()[p] < end; ++p) {
      const double common = std::min(end, curve.ends()[p + 1]) - std::max(begin, curve.ends()[p]);
      if (common > nothing) sum += common * near[p];
    }
    begin = end;
    const bool opposed = !(sum.norm() > 1e-9 * curve.length());
    Quaterniond turn;
    turn.coeffs() = opposed ? near[first] : sum.normalized();
    result.push_back(turn);
  }
  return result;
}

Quaterniond Redirected(const Quaterniond& turn, const Vector3d& from, const Vector3d& to) {
  return (Quaterniond::FromTwoVectors(from, to) * turn).normalized();
}

}  // namespace keypose::armature
