#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/kd_tree.h"
#include "core/parallel.h"
#include "reconstruct/flip.h"

namespace keypose::reconstruct {
namespace {

/// Points with the shares that red, green and blue have in their colour.
struct Cloud {
  PointsX3 points, colors;
  Eigen::Index size() const { return points.rows(); }
};

/// At most `count` of a scene's points, evenly through their list, without those far from all others.
Cloud Thinned(const Scene& scene, int count) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    std::vector<double> values;
    for (const SparsePoint& point : scene.points) values.push_back(point.position[k]);
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
    middle[k] = values[values.size() / 2];
  }
  std::vector<double> reach;
  for (const SparsePoint& point : scene.points) reach.push_back((point.position - middle).norm());
  std::vector<double> sorted = reach;
  std::sort(sorted.begin(), sorted.end());
  const double limit = 1.3 * sorted[sorted.size() * 98 / 100];
  std::vector<std::size_t> good;
  for (std::size_t i = 0; i < reach.size(); ++i)
    if (reach[i] <= limit) good.push_back(i);
  const auto wanted = std::min<std::size_t>(good.size(), static_cast<std::size_t>(count));
  Cloud cloud{PointsX3(static_cast<Eigen::Index>(wanted), 3), PointsX3(static_cast<Eigen::Index>(wanted), 3)};
  for (std::size_t k = 0; k < wanted; ++k) {
    const SparsePoint& point = scene.points[good[k * good.size() / wanted]];
    const Eigen::Vector3d color = point.color.cast<double>() + Eigen::Vector3d::Constant(8);
    cloud.points.row(static_cast<Eigen::Index>(k)) = point.position.transpose();
    cloud.colors.row(static_cast<Eigen::Index>(k)) = color.transpose() / color.sum();
  }
  return cloud;
}

double Spread(const PointsX3& points) { return std::sqrt((points.rowwise() - points.colwise().mean()).rowwise().squaredNorm().mean()); }

/// Median distance of a point to its nearest neighbour: finer than this a cloud tells no place.
double Spacing(const Cloud& cloud, const KdTree& tree) {
  std::vector<double> distances;
  for (Eigen::Index i = 0; i < cloud.size(); ++i)
    distances.push_back(tree.Nearest(cloud.points.row(i).transpose(), 2).back().squared_distance);
  std::nth_element(distances.begin(), distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2), distances.end());
  return std::sqrt(distances[distances.size() / 2]);
}

/// Turns spread evenly over all there are: a spiral on the unit quaternions.
/// Source: Alexa, "Super-Fibonacci spirals", CVPR 2022.
Eigen::Matrix3d Turn(int i, int count) {
  constexpr double kPhi = 1.4142135623730951, kPsi = 1.533751168755204288118041, kTwoPi = 6.283185307179586;
  const double s = i + 0.5, t = s / count, r = std::sqrt(t), q = std::sqrt(1 - t), a = kTwoPi * s / kPhi, b = kTwoPi * s / kPsi;
  return Eigen::Quaterniond(q * std::cos(b), r * std::sin(a), r * std::cos(a), q * std::sin(b)).normalized().toRotationMatrix();
}

/// One step of trimmed ICP. @return the mean distance of the pairs kept
double TrimmedStep(const Cloud& first, const KdTree& tree, const Cloud& second, double kept, Similarity3& first_from_second) {
  std::vector<std::pair<double, Eigen::Index>> order;
  std::vector<int> nearest;
  for (Eigen::Index i = 0; i < second.size(); ++i) {
    const KdTree::Neighbor n = tree.Nearest(first_from_second * Eigen::Vector3d(second.points.row(i).transpose()));
    order.emplace_back(n.squared_distance, i);
    nearest.push_back(n.index);
  }
  std::sort(order.begin(), order.end());
  const auto count = static_cast<Eigen::Index>(kept * static_cast<double>(order.size()));
  PointsX3 from(count, 3), to(count, 3);
  double sum = 0;
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto [squared, i] = order[static_cast<std::size_t>(k)];
    from.row(k) = second.points.row(i);
    to.row(k) = first.points.row(nearest[static_cast<std::size_t>(i)]);
    sum += std::sqrt(squared);
  }
  first_from_second = FitSimilarity(from, to, {}, false);
  return sum / static_cast<double>(count);
}

void Settle(const Cloud& first, const KdTree& tree, const Cloud& second, double kept, int rounds, Similarity3& first_from_second) {
  double last = 1e300;
  for (int round = 0; round < rounds; ++round) {
    const double mean = TrimmedStep(first, tree, second, kept, first_from_second);
    if (mean > last * (1 - 1e-4)) break;
    last = mean;
  }
}

/// Share of the second cloud's points that have one of the first beside them, of their colour; and the rms of these.
std::pair<double, double> Agreement(const Cloud& first, const KdTree& tree, const Cloud& second, const Similarity3& first_from_second,
                                    double limit, double max_color) {
  int agreeing = 0;
  double sum = 0;
  for (Eigen::Index i = 0; i < second.size(); ++i) {
    const KdTree::Neighbor n = tree.Nearest(first_from_second * Eigen::Vector3d(second.points.row(i).transpose()));
    if (n.squared_distance > limit * limit || (first.colors.row(n.index) - second.colors.row(i)).norm() > max_color) continue;
    ++agreeing;
    sum += n.squared_distance;
  }
  return {static_cast<double>(agreeing) / static_cast<double>(second.size()), agreeing > 0 ? std::sqrt(sum / agreeing) : 0};
}

/// Normals of planes through each point's neighbours, of either sign.
PointsX3 PlaneNormals(const Cloud& cloud, const KdTree& tree) {
  constexpr int kNeighbors = 12;
  PointsX3 normals(cloud.size(), 3);
  ParallelFor(
      cloud.size(),
      [&](std::int64_t i) {
        const auto near = tree.Nearest(cloud.points.row(i).transpose(), kNeighbors);
        Eigen::RowVector3d mean = Eigen::RowVector3d::Zero();
        for (const KdTree::Neighbor& n : near) mean += cloud.points.row(n.index) / static_cast<double>(near.size());
        Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
        for (const KdTree::Neighbor& n : near)
          scatter += (cloud.points.row(n.index) - mean).transpose() * (cloud.points.row(n.index) - mean);
        normals.row(i) = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(0).transpose();
      },
      256);
  return normals;
}

/// Point-to-plane steps over pairs that agree: sparse points of two halves are never the same ones, but lie on one surface.
/// Source: Chen & Medioni, "Object modelling by registration of multiple range images", 1992.
void Polish(const Cloud& first, const KdTree& tree, const PointsX3& normals, const Cloud& second, double limit, double max_color,
            Similarity3& first_from_second) {
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  for (int round = 0; round < 40; ++round) {
    Eigen::Matrix<double, 6, 6> normal = 1e-9 * Eigen::Matrix<double, 6, 6>::Identity();
    Vector6 right = Vector6::Zero();
    for (Eigen::Index i = 0; i < second.size(); ++i) {
      const Eigen::Vector3d x = first_from_second * Eigen::Vector3d(second.points.row(i).transpose());
      const KdTree::Neighbor n = tree.Nearest(x);
      if (n.squared_distance > limit * limit || (first.colors.row(n.index) - second.colors.row(i)).norm() > max_color) continue;
      const Eigen::Vector3d m = normals.row(n.index).transpose();
      const double off = m.dot(x - first.points.row(n.index).transpose());
      const double weight = 1 / (1 + std::pow(off / (0.15 * limit), 2));  // Cauchy
      Vector6 row;
      row << x.cross(m), m;
      normal += weight * row * row.transpose();
      right -= weight * off * row;
    }
    const Vector6 step = normal.ldlt().solve(right);
    const Eigen::Vector3d turn = step.head<3>();
    const Eigen::Matrix3d rotation = turn.norm() > 0 ? Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix()
                                                     : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
    first_from_second.rotation = rotation * first_from_second.rotation;
    first_from_second.translation = rotation * first_from_second.translation + step.tail<3>();
    if (step.norm() < 1e-9) break;
  }
}

struct Candidate {
  Similarity3 motion;
  double share = 0, rms = 0;
};

double AngleBetween(const Similarity3& a, const Similarity3& b) {
  return std::acos(std::clamp(((a.rotation.transpose() * b.rotation).trace() - 1) / 2, -1.0, 1.0));
}

}  // namespace

Join JoinByShape(const Scene& first, const Scene& second, const ShapeJoinOptions& options) {
  constexpr std::size_t kRefined = 16;
  constexpr double kAnotherTurn = 0.26;  // 15 degrees
  Join join;
  if (first.points.size() < 100 || second.points.size() < 100) return join;
  const Cloud target = Thinned(first, 8 * options.fine_points), coarse = Thinned(second, options.coarse_points),
              fine = Thinned(second, options.fine_points);
  const KdTree tree(target.points);
  const double limit = std::max(options.max_distance * Spread(target.points), 2 * Spacing(target, tree));
  const Eigen::Vector3d from = coarse.points.colwise().mean(), to = target.points.colwise().mean();
  std::vector<Candidate> candidates(static_cast<std::size_t>(options.rotations));
  ParallelFor(options.rotations, [&](std::int64_t i) {
    Candidate& candidate = candidates[static_cast<std::size_t>(i)];
    candidate.motion.rotation = Turn(static_cast<int>(i), options.rotations);
    candidate.motion.translation = to - candidate.motion.rotation * from;
    Settle(target, tree, coarse, options.kept, 25, candidate.motion);
    candidate.share = Agreement(target, tree, coarse, candidate.motion, 2 * limit, options.max_color).first;
  });
  std::stable_sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) { return a.share > b.share; });
  candidates.resize(std::min(candidates.size(), kRefined));
  ParallelFor(static_cast<std::int64_t>(candidates.size()), [&](std::int64_t i) {
    Candidate& candidate = candidates[static_cast<std::size_t>(i)];
    Settle(target, tree, fine, options.kept, 60, candidate.motion);
    std::tie(candidate.share, candidate.rms) = Agreement(target, tree, fine, candidate.motion, limit, options.max_color);
  });
  std::stable_sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) { return a.share > b.share; });
  const Candidate& best = candidates.front();
  double rival = 0;
  for (const Candidate& candidate : candidates)
    if (AngleBetween(candidate.motion, best.motion) > kAnotherTurn) rival = std::max(rival, candidate.share);
  join.first_from_second = best.motion;
  Polish(target, tree, PlaneNormals(target, tree), Thinned(second, 8 * options.fine_points), limit, options.max_color,
         join.first_from_second);
  join.pairs = static_cast<int>(fine.size());
  join.agreeing = static_cast<int>(std::lround(best.share * static_cast<double>(fine.size())));
  join.rms = best.rms;
  join.found = best.share >= options.min_share && rival <= options.max_rival * best.share;
  return join;
}

}  // namespace keypose::reconstruct
