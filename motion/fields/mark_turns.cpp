#include "motion/fields/mark_turns.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/numbers/kd_tree.h"
#include "core/numbers/rotations.h"
#include "core/values/angles.h"
#include "core/values/size_of.h"
#include "deform/levels/edge_collapse.h"
#include "deform/levels/geodesics.h"

namespace keypose::motion {

namespace {

constexpr int kMostVertices = 2000;
constexpr int kNeighbours = 6;
constexpr double kNoRemainder = 1e-12;  // rad
/// Two rotations whose difference is nearer to half a turn than this could be joined either way.
constexpr double kEitherWay = 1e-6;

/// A unit quaternion with its first coefficient that is not zero positive, in the order w, x, y, z.
Eigen::Quaterniond Canonical(const Eigen::Quaterniond& given) {
  Eigen::Quaterniond q = given.normalized();
  for (const double c : {q.w(), q.x(), q.y(), q.z()})
    if (c != 0) {
      if (c < 0) q.coeffs() = -q.coeffs();
      break;
    }
  return q;
}

Eigen::MatrixXd DistancesBetween(const PointsX3& points, const FacesX3& faces,
                                 const std::vector<MarkPlace>& places) {
  DecimatedMesh mesh = ToDecimatedMesh(points, faces);
  std::vector<int> parent(points.rows());
  std::iota(parent.begin(), parent.end(), 0);
  if (SizeOf(mesh.vertex) > kMostVertices) DecimateInRounds(mesh, kMostVertices, parent);
  FacesX3 coarse(std::ssize(mesh.faces), 3);
  for (int f = 0; f < SizeOf(mesh.faces); ++f)
    coarse.row(f) << mesh.faces[f][0], mesh.faces[f][1], mesh.faces[f][2];
  const GeodesicGraph graph(mesh.points, coarse);
  const KdTree tree(mesh.points);
  std::vector<int> sources;
  for (const MarkPlace& place : places)
    sources.push_back(tree.Nearest(PositionOf(place, points, faces).transpose()).index);
  const Eigen::MatrixXd rows = graph.Rows(sources);
  Eigen::MatrixXd between(std::ssize(places), std::ssize(places));
  for (int a = 0; a < SizeOf(places); ++a)
    for (int b = 0; b < SizeOf(places); ++b) between(a, b) = rows(a, sources[b]);
  return between;
}

}  // namespace

MarkTree JoinMarks(const PointsX3& points, const FacesX3& faces,
                   const std::vector<MarkPlace>& places) {
  const Eigen::MatrixXd between = DistancesBetween(points, faces, places);
  const int count = SizeOf(places);
  MarkTree tree;
  tree.central.resize(count);
  std::iota(tree.central.begin(), tree.central.end(), 0);
  const Eigen::VectorXd mean = between.rowwise().mean();
  std::stable_sort(tree.central.begin(), tree.central.end(),
                   [&](int a, int b) { return mean[a] < mean[b]; });
  for (int k = 0; k < count; ++k) {
    std::vector<int> others;
    for (int j = 0; j < count; ++j)
      if (j != k) others.push_back(j);
    std::stable_sort(others.begin(), others.end(),
                     [&](int a, int b) { return between(k, a) < between(k, b); });
    others.resize(std::min(SizeOf(others), kNeighbours));
    tree.nearest.push_back(std::move(others));
  }
  std::vector<double> nearest(count, std::numeric_limits<double>::infinity());
  std::vector<int> parent(count, -1);
  std::vector<char> in(count, 0);
  int next = tree.central[0];
  parent[next] = next;
  for (int k = 0; k < count; ++k) {
    in[next] = 1;
    tree.steps.push_back({next, parent[next]});
    int best = -1;
    for (int i = 0; i < count; ++i) {
      if (in[i]) continue;
      if (between(next, i) < nearest[i]) {
        nearest[i] = between(next, i);
        parent[i] = next;
      }
      if (best < 0 || nearest[i] < nearest[best]) best = i;
    }
    next = best;
  }
  return tree;
}

std::vector<Eigen::Quaterniond> WithAgreeingSigns(const MarkTree& tree,
                                                  const std::vector<Eigen::Quaterniond>& given) {
  std::vector<Eigen::Quaterniond> result(given.size());
  for (const auto& [mark, parent] : tree.steps) {
    result[mark] = Canonical(given[mark]);
    if (mark != parent && result[mark].dot(result[parent]) < 0)
      result[mark].coeffs() = -result[mark].coeffs();
  }
  return result;
}

int BodyMarks(int marks) { return std::min(marks, std::max(3, marks / 3)); }

TurnFollower::TurnFollower(MarkTree tree, bool follow) : tree_(std::move(tree)), follow_(follow) {}

Eigen::Quaterniond TurnFollower::BodyOf(const std::vector<Eigen::Quaterniond>& rotations) const {
  const Eigen::Quaterniond root = Canonical(rotations[tree_.central[0]]);
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  for (int k = 0; k < BodyMarks(SizeOf(tree_.central)); ++k) {
    const Eigen::Quaterniond q = Canonical(rotations[tree_.central[k]]);
    sum += q.dot(root) < -kEitherWay ? (-q.coeffs()).eval() : q.coeffs();
  }
  return sum.norm() > kEitherWay ? Eigen::Quaterniond(sum.normalized()) : root;
}

MarkTurns TurnFollower::Next(const std::vector<Eigen::Quaterniond>& rotations) {
  const Eigen::Quaterniond body = BodyOf(rotations);
  std::vector<Eigen::Quaterniond> relative(rotations.size());
  for (std::size_t k = 0; k < rotations.size(); ++k)
    relative[k] = Canonical(body.conjugate() * rotations[k]);
  std::vector<Eigen::Vector3d> turns(rotations.size());
  for (const auto& [mark, parent] : tree_.steps) {
    const Eigen::Vector3d shortest = LogOf(relative[mark]);
    const bool continues =
        follow_ && !before_.empty() &&
        AngleOfDifference(RotationDifference(before_[mark], relative[mark])) < 0.5 * kPi;
    if (continues)
      turns[mark] = TurnAfter(turns_[mark], before_[mark], relative[mark]);
    else if (!follow_ || mark == parent || (shortest - turns[parent]).norm() <= kPi + kEitherWay)
      turns[mark] = shortest;
    else
      turns[mark] = TurnAfter(turns[parent], relative[parent], relative[mark]);
    largest_between_ = std::max(largest_between_, (turns[mark] - turns[parent]).norm());
  }
  MarkTurns result{body.toRotationMatrix(), PointsX3(std::ssize(turns), 3),
                   PointsX3(std::ssize(turns), 3)};
  for (int k = 0; k < SizeOf(turns); ++k) {
    result.turns.row(k) = turns[k];
    result.remainders.row(k) = LogOf(QuaternionOf(-turns[k]) * relative[k]);
  }
  if (result.remainders.cwiseAbs().maxCoeff() < kNoRemainder) result.remainders.resize(0, 3);
  before_ = std::move(relative);
  turns_ = std::move(turns);
  return result;
}

}  // namespace keypose::motion
