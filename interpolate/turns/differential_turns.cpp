#include "interpolate/turns/differential_turns.h"

#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <algorithm>
#include <iterator>

#include "core/numbers/cholesky.h"
#include "core/numbers/parallel.h"
#include "core/values/size_of.h"
#include "interpolate/turns/turns.h"

namespace keypose::interpolation {

namespace {

constexpr int kMaxPasses = 30;
constexpr double kSettled = 1e-13;  // [rad]

}  // namespace

struct DifferentialTurns::Impl {
  struct Pair {
    int a, b;
    Eigen::Vector3d turn;  // log(R_a^T R_b)
  };

  Impl(const PoissonSystem& system, const SegmentMaps& maps) {
    const auto neighbours = FaceNeighbours(system.vertex_count(), system.faces());
    const Eigen::Matrix3d back = ExpOf(maps.body_turn).transpose();
    std::vector<char> loose;
    for (const FaceMap& map : maps.faces) {
      loose.push_back(map.degenerate);
      rotations.push_back(back * map.rotation);
    }
    int root = 0;
    for (std::size_t f = 0; f < maps.faces.size(); ++f)
      if (!loose[f] && (loose[root] || maps.faces[f].turn.norm() < maps.faces[root].turn.norm()))
        root = static_cast<int>(f);
    const std::vector<Eigen::Quaterniond> quaternions(rotations.begin(), rotations.end());
    tree = GrowTree(neighbours, quaternions, loose, {root});
    for (const auto& [face, parent] : tree.steps)
      if (loose[face]) rotations[face] = rotations[parent];
    for (const auto& [face, parent] : tree.steps)
      steps.push_back(face == parent ? maps.faces[face].turn
                                     : LogOf(rotations[parent].transpose() * rotations[face]));
    for (const auto& [face, parent] : tree.steps)
      if (face == parent) root_remainders.push_back(maps.faces[face].remainder);
    for (int f = 0; f < std::ssize(neighbours); ++f)
      for (int g : neighbours[f])
        if (g > f) pairs.push_back({f, g, LogOf(rotations[f].transpose() * rotations[g])});
    Factor();
  }

  void Factor() {
    const int n = SizeOf(rotations);
    std::vector<Eigen::Triplet<double>> triplets;
    for (const Pair& p : pairs) {
      triplets.emplace_back(p.a, p.a, 1.0);
      triplets.emplace_back(p.b, p.b, 1.0);
      triplets.emplace_back(std::max(p.a, p.b), std::min(p.a, p.b), -1.0);
    }
    for (const auto& [face, parent] : tree.steps)
      if (face == parent) triplets.emplace_back(face, face, 1.0);
    Eigen::SparseMatrix<double> graph(n, n);
    graph.setFromTriplets(triplets.begin(), triplets.end());
    solver.Analyze(graph);
    solver.Factor(graph);
  }

  std::vector<Eigen::Matrix3d> At(double t) const {
    std::vector<Eigen::Matrix3d> q(rotations.size());
    std::vector<int> root_of(rotations.size());
    auto remainder = root_remainders.begin();
    for (std::size_t k = 0; k < tree.steps.size(); ++k) {
      const auto [face, parent] = tree.steps[k];
      q[face] = (face == parent ? ExpOf(t * steps[k]) * ExpOf(t * *remainder++)
                                : q[parent] * ExpOf(t * steps[k]))
                    .eval();
      root_of[face] = face == parent ? face : root_of[parent];
    }
    std::vector<Eigen::Matrix3d> wanted(pairs.size());
    ParallelFor(
        std::ssize(pairs),
        [&](std::int64_t k) { wanted[k] = ExpOf(t * pairs[k].turn).transpose(); }, 512);
    std::vector<Eigen::Vector3d> residual(pairs.size());
    for (int pass = 0; pass < kMaxPasses; ++pass) {
      ParallelFor(
          std::ssize(pairs),
          [&](std::int64_t k) {
            residual[k] = LogOf(q[pairs[k].b] * wanted[k] * q[pairs[k].a].transpose());
          },
          512);
      Eigen::MatrixXd x = Eigen::MatrixXd::Zero(std::ssize(q), 3);
      for (std::size_t k = 0; k < pairs.size(); ++k) {
        x.row(pairs[k].a) += residual[k];
        x.row(pairs[k].b) -= residual[k];
      }
      solver.SolveInPlace(x);
      double largest = 0;
      for (std::size_t f = 0; f < q.size(); ++f) {
        const Eigen::Vector3d step = x.row(f) - x.row(root_of[f]);
        q[f] = ExpOf(step) * q[f];
        largest = std::max(largest, step.norm());
      }
      if (largest < kSettled) break;
    }
    return q;
  }

  std::vector<Eigen::Matrix3d> rotations;  // relative to the body, at t = 1
  FaceTree tree;
  std::vector<Eigen::Vector3d> steps;  // from the parent; for roots their turn
  std::vector<Eigen::Vector3d> root_remainders;
  std::vector<Pair> pairs;
  SparseCholesky solver;
};

DifferentialTurns::DifferentialTurns(const PoissonSystem& system, const SegmentMaps& maps)
    : impl_(std::make_unique<Impl>(system, maps)) {}
DifferentialTurns::~DifferentialTurns() = default;
DifferentialTurns::DifferentialTurns(DifferentialTurns&&) noexcept = default;
std::vector<Eigen::Matrix3d> DifferentialTurns::At(double t) const { return impl_->At(t); }

}  // namespace keypose::interpolation
