#include "deform/arap/arap_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"
#include "deform/solvers/block_jacobi.h"
#include "deform/solvers/sparse_pattern.h"

namespace keypose {

namespace {

constexpr double kSmallestCotangent = 1e-3, kHold = 1e-7;
// of the first residual's energy; more accuracy is not needed, because the maps change in each
// iteration
constexpr double kSolverTolerance = 1e-2;
constexpr double kBlockTolerance = 1e-4;  // the same when there is no factor
constexpr int kBlockSteps = 3;            // steps without a factor for each step with one
constexpr std::int64_t kFitGrain = 1024;
constexpr int kRootSteps = 30;
constexpr double kRootTolerance = 1e-14, kWellDetermined = 1e-3;

Eigen::Matrix3d RotationBySvd(const Eigen::Matrix3d& m) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d u = svd.matrixU();
  if ((u * svd.matrixV().transpose()).determinant() < 0) u.col(2) *= -1;
  return u * svd.matrixV().transpose();
}

}  // namespace

Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& m) {
  // Source: Markley 1993 (FOAM). Given the sum of the singular values (the last one signed), the
  // rotation is a polynomial of m.
  Eigen::Matrix3d cofactor;
  cofactor.row(0) = m.row(1).cross(m.row(2));
  cofactor.row(1) = m.row(2).cross(m.row(0));
  cofactor.row(2) = m.row(0).cross(m.row(1));
  const double squares = m.squaredNorm(), minors = cofactor.squaredNorm(),
               determinant = m.row(0).dot(cofactor.row(0));
  // This sum is the largest root of a quartic with real roots, so Newton's method from above
  // converges to it.
  double sum = std::sqrt(3 * squares);
  for (int round = 0; round < kRootSteps; ++round) {
    const double square = sum * sum - squares;
    const double step = (square * square - 8 * sum * determinant - 4 * minors) /
                        (4 * (sum * square - 2 * determinant));
    if (!(step > kRootTolerance * sum)) break;
    sum -= step;
  }
  const double pairs = (sum * sum - squares) / 2, product = pairs * sum - determinant;
  // For fans on a line and mirrored fans the rotation is not unique or ill-conditioned.
  if (!(product > kWellDetermined * sum * sum * sum)) return RotationBySvd(m);
  return ((pairs + squares) * m + sum * cofactor - m * (m.transpose() * m)) / product;
}

ArapFit::ArapFit(const PointsX3& rest, const FacesX3& faces, const Eigen::VectorXd& stiffness,
                 double smoothing, bool factor)
    : rest_(rest), smoothing_(smoothing), factored_(factor) {
  const std::size_t n = rest.rows();
  areas_ = VertexAreas(rest, faces);
  pieces_ = RigidPieces(faces, stiffness, areas_);
  stiffness_ = RigidPieces::Held(stiffness);
  BuildEdges(faces, stiffness_);
  BuildMatrix();
  BuildFans();
  hold_ = Eigen::VectorXd::Zero(rest.rows());
  maps_.assign(n, Eigen::Matrix3d::Identity());
}

void ArapFit::BuildEdges(const FacesX3& faces, const Eigen::VectorXd& stiffness) {
  // One entry for each corner and side, sorted. This is much faster than a map of edges.
  struct Half {
    int i, j;
    double w;
  };
  std::vector<Half> halves;
  halves.reserve(faces.size() * 2);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int i = faces(f, k), j = faces(f, (k + 1) % 3), o = faces(f, (k + 2) % 3);
      const Eigen::Vector3d a = rest_.row(i) - rest_.row(o), b = rest_.row(j) - rest_.row(o);
      const double cross = a.cross(b).norm();
      const double cotangent = cross > 0 ? a.dot(b) / cross : 0;
      halves.push_back({i, j, cotangent / 2});
      halves.push_back({j, i, cotangent / 2});
    }
  std::sort(halves.begin(), halves.end(),
            [](const Half& a, const Half& b) { return a.i != b.i ? a.i < b.i : a.j < b.j; });
  offset_.assign(rest_.rows() + 1, 0);
  for (std::size_t s = 0; s < halves.size();) {
    const int i = halves[s].i, j = halves[s].j;
    double w = 0;
    for (; s < halves.size() && halves[s].i == i && halves[s].j == j; ++s) w += halves[s].w;
    w = std::clamp(w, kSmallestCotangent, 20.0);
    if (stiffness.size() > 0) w *= std::sqrt(stiffness[i] * stiffness[j]);
    if (i == j) continue;
    neighbour_.push_back(j);
    weight_.push_back(w);
    ++offset_[i + 1];
  }
  for (std::size_t i = 0; i + 1 < offset_.size(); ++i) offset_[i + 1] += offset_[i];
}

void ArapFit::BuildMatrix() {
  const int n = static_cast<int>(rest_.rows());
  std::vector<std::pair<int, int>> edges;
  std::vector<int> columns(1, 0), rows;
  std::vector<double> values;
  diagonal_.resize(n);
  for (int i = 0; i < n; ++i) {
    double sum = 0;
    for (int s = offset_[i]; s < offset_[i + 1]; ++s) sum += weight_[s];
    diagonal_[i] = SizeOf(rows);
    rows.push_back(i);
    values.push_back(sum);
    for (int s = offset_[i]; s < offset_[i + 1]; ++s)
      if (neighbour_[s] > i) {
        edges.emplace_back(i, neighbour_[s]);
        rows.push_back(neighbour_[s]);
        values.push_back(-weight_[s]);
      }
    columns.push_back(SizeOf(rows));
  }
  lower_ = Eigen::Map<const Eigen::SparseMatrix<double>>(n, n, std::ssize(rows), columns.data(),
                                                         rows.data(), values.data());
  system_ = lower_;
  if (factored_) factor_.Analyze(lower_);
  component_ = Components(n, edges, components_);
}

void ArapFit::BuildFans() {
  moments_.assign(rest_.rows(), Eigen::Matrix3d::Zero());
  inverse_.clear();
  size_.assign(rest_.rows(), 0);
  edge_.resize(neighbour_.size());
  for (Eigen::Index i = 0; i < rest_.rows(); ++i) {
    double sum = 0;
    for (int s = offset_[i]; s < offset_[i + 1]; ++s) {
      const Eigen::Vector3d edge = edge_[s] = (rest_.row(i) - rest_.row(neighbour_[s])).transpose();
      moments_[i] += weight_[s] * edge * edge.transpose();
      sum += weight_[s];
    }
    size_[i] = 0.5 * moments_[i].trace();
    moments_[i].diagonal().array() += smoothing_ * sum;
  }
}

void ArapFit::SetWeights(const Eigen::VectorXd& weights) {
  std::vector<double> pull_of(components_, 0);
  for (Eigen::Index i = 0; i < weights.size(); ++i) pull_of[component_[i]] += weights[i];
  for (Eigen::Index i = 0; i < weights.size(); ++i) {
    hold_[i] = pull_of[component_[i]] < kHold ? kHold : 0;
    system_.valuePtr()[diagonal_[i]] = lower_.valuePtr()[diagonal_[i]] + weights[i] + hold_[i];
  }
  if (factored_) factor_.Factor(system_);
}

// The rigidity must grow with the stiffness: stiffer edges alone scale both terms and do not make
// the map more rigid.
double ArapFit::Hold(int i) const {
  return rigidity_ * size_[i] * (stiffness_.size() > 0 ? stiffness_[i] : 1);
}

Eigen::Matrix3d ArapFit::FanMap(const PointsX3& moved, int i) const {
  Eigen::Matrix3d m = Eigen::Matrix3d::Zero();
  const Eigen::Vector3d at = moved.row(i).transpose();
  for (int s = offset_[i]; s < offset_[i + 1]; ++s) {
    const int j = neighbour_[s];
    const Eigen::Vector3d& edge = edge_[s];
    const Eigen::Vector3d pulled = weight_[s] * (at - moved.row(j).transpose());
    const double alike = smoothing_ * weight_[s];
    const Eigen::Matrix3d& other = previous_[j];
    // Column by column, so that all values stay in registers.
    m.col(0) = (m.col(0) + pulled * edge[0]) + alike * other.col(0);
    m.col(1) = (m.col(1) + pulled * edge[1]) + alike * other.col(1);
    m.col(2) = (m.col(2) + pulled * edge[2]) + alike * other.col(2);
  }
  const Eigen::Matrix3d rotation = NearestRotation(m);
  if (rigid()) return rotation;
  return (m + Hold(i) * rotation) * inverse_[i];
}

void ArapFit::SetRigidity(double rigidity) {
  if (rigidity != rigidity_) inverse_.clear();
  rigidity_ = rigidity;
}

void ArapFit::InvertMoments() {
  inverse_.resize(moments_.size());
  ParallelBlocks(rest_.rows(), kFitGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      if (!(size_[i] > 0)) continue;
      Eigen::Matrix3d held = moments_[i];
      held.diagonal().array() += Hold(static_cast<int>(i));
      inverse_[i] = held.inverse();
    }
  });
}

void ArapFit::FitMaps(const PointsX3& moved) {
  previous_ = maps_;
  if (!rigid() && inverse_.empty()) InvertMoments();
  ParallelBlocks(moved.rows(), kFitGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i)
      if (size_[i] > 0) maps_[i] = FanMap(moved, static_cast<int>(i));
  });
  pieces_.ShareMaps(rest_, moved, maps_);
}

void ArapFit::AddShapePull(Eigen::MatrixXd& b) const {
  ParallelBlocks(rest_.rows(), kFitGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (int s = offset_[i]; s < offset_[i + 1]; ++s) {
        const int j = neighbour_[s];
        sum.noalias() += (0.5 * weight_[s]) * ((maps_[i] + maps_[j]) * edge_[s]);
      }
      b.row(i) += sum.transpose();
    }
  });
}

Pulls::Pulls(Eigen::Index vertices)
    : q(vertices, Eigen::Matrix3d::Zero()), b(PointsX3::Zero(vertices, 3)) {}

void Pulls::AddPoint(Eigen::Index vertex, double weight, const Eigen::Vector3d& goal) {
  q[vertex].diagonal().array() += weight;
  b.row(vertex) += weight * goal.transpose();
}

void Pulls::AddPlane(Eigen::Index vertex, double weight, const Eigen::Vector3d& normal,
                     const Eigen::Vector3d& goal) {
  q[vertex].noalias() += (weight * normal) * normal.transpose();
  b.row(vertex) += weight * normal.dot(goal) * normal.transpose();
}

Eigen::VectorXd Pulls::MeanWeights() const {
  Eigen::VectorXd weights(b.rows());
  for (Eigen::Index i = 0; i < weights.size(); ++i) weights[i] = q[i].trace() / 3;
  return weights;
}

Eigen::MatrixXd ArapFit::Apply(const Eigen::MatrixXd& p, const Pulls& pulls) const {
  Eigen::MatrixXd result(p.rows(), 3);
  ParallelBlocks(p.rows(), kFitGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      const Eigen::Vector3d x = p.row(i);
      Eigen::Vector3d sum = pulls.q[i] * x + hold_[i] * x;
      for (int s = offset_[i]; s < offset_[i + 1]; ++s)
        sum += weight_[s] * (x - p.row(neighbour_[s]).transpose());
      result.row(i) = sum.transpose();
    }
  });
  return result;
}

Eigen::VectorXd ArapFit::Rings() const {
  Eigen::VectorXd sums(rest_.rows());
  for (Eigen::Index i = 0; i < sums.size(); ++i) sums[i] = lower_.valuePtr()[diagonal_[i]];
  return sums;
}

PointsX3 ArapFit::ShapePull() const {
  Eigen::MatrixXd b = Eigen::MatrixXd::Zero(rest_.rows(), 3);
  AddShapePull(b);
  return b;
}

PointsX3 ArapFit::FitPositions(const Pulls& pulls, const PointsX3& start, int steps) const {
  Eigen::MatrixXd b = pulls.b + hold_.asDiagonal() * start;
  AddShapePull(b);
  std::optional<BlockJacobi> blocks;
  if (!factored_) blocks.emplace(pulls.q, Eigen::VectorXd(Rings() + hold_));
  const auto precondition = [&](const Eigen::MatrixXd& residual) {
    return blocks ? blocks->Apply(residual) : factor_.Solve(residual);
  };
  Eigen::MatrixXd x = start, r = b - Apply(x, pulls), z = precondition(r), p = z;
  double rz = r.cwiseProduct(z).sum();
  const double enough = (blocks ? kBlockTolerance : kSolverTolerance) * rz;
  if (blocks) steps *= kBlockSteps;
  for (int k = 0; k < steps && rz > enough && rz > 0; ++k) {
    const Eigen::MatrixXd ap = Apply(p, pulls);
    const double step = rz / p.cwiseProduct(ap).sum();
    x += step * p;
    r -= step * ap;
    z = precondition(r);
    const double next = r.cwiseProduct(z).sum();
    p = z + (next / rz) * p;
    rz = next;
  }
  return x;
}

Eigen::VectorXd ArapFit::Strain(const PointsX3& moved) const {
  Eigen::VectorXd strain = Eigen::VectorXd::Zero(rest_.rows());
  for (Eigen::Index i = 0; i < rest_.rows(); ++i) {
    double fan = 0;
    for (int s = offset_[i]; s < offset_[i + 1]; ++s) {
      const int j = neighbour_[s];
      const Eigen::Vector3d miss = (moved.row(i) - moved.row(j)).transpose() - maps_[i] * edge_[s];
      strain[i] += weight_[s] * miss.squaredNorm();
      fan += weight_[s] * edge_[s].squaredNorm();
    }
    if (fan > 0) strain[i] /= fan;
  }
  return strain;
}

double ArapFit::BestScale(const PointsX3& moved) const {
  double across = 0, own = 0;
  for (Eigen::Index i = 0; i < rest_.rows(); ++i)
    for (int s = offset_[i]; s < offset_[i + 1]; ++s) {
      const int j = neighbour_[s];
      const Eigen::Vector3d wanted = maps_[i] * edge_[s];
      across += weight_[s] * wanted.dot((moved.row(i) - moved.row(j)).transpose());
      own += weight_[s] * wanted.squaredNorm();
    }
  return own > 0 && across > 0 ? across / own : 1;
}

void ArapFit::ScaleRest(double factor) {
  rest_ *= factor;
  BuildFans();
}

}  // namespace keypose
