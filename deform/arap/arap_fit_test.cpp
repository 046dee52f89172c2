// The as-rigid-as-possible fit against its own definition, evaluated naively.
#include "deform/arap/arap_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "core/numbers/parallel.h"
#include "core/surfaces/shapes.h"
#include "deform/arap/testing/random_matrix.h"

namespace keypose::arap_fit_test {

/// c_ij for both directions, straight from the definition.
std::map<std::pair<int, int>, double> Weights(const Mesh& mesh,
                                              const Eigen::VectorXd& stiffness = {}) {
  std::map<std::pair<int, int>, double> c;
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int i = mesh.faces(f, k), j = mesh.faces(f, (k + 1) % 3),
                o = mesh.faces(f, (k + 2) % 3);
      const Eigen::RowVector3d a = mesh.points.row(i) - mesh.points.row(o),
                               b = mesh.points.row(j) - mesh.points.row(o);
      const double angle = std::acos(a.normalized().dot(b.normalized()));
      c[{i, j}] += 0.5 / std::tan(angle);
      c[{j, i}] += 0.5 / std::tan(angle);
    }
  for (auto& [edge, w] : c) {
    w = std::clamp(w, 1e-3, 20.0);
    if (stiffness.size() > 0) w *= std::sqrt(stiffness[edge.first] * stiffness[edge.second]);
  }
  return c;
}

double PullEnergy(const Pulls& pulls, const PointsX3& p) {
  double sum = 0;
  for (Eigen::Index i = 0; i < p.rows(); ++i) {
    const Eigen::Vector3d x = p.row(i);
    sum += x.dot(pulls.q[i] * x) - 2 * pulls.b.row(i).dot(x);
  }
  return sum;
}

double Energy(const Mesh& mesh, const std::map<std::pair<int, int>, double>& c, double kappa,
              const std::vector<Eigen::Matrix3d>& maps, const PointsX3& p, const Pulls& pulls) {
  double sum = PullEnergy(pulls, p);
  for (const auto& [edge, w] : c) {
    const auto& [i, j] = edge;
    const Eigen::Vector3d rest = mesh.points.row(i) - mesh.points.row(j),
                          moved = p.row(i) - p.row(j);
    sum += 0.5 * w * (moved - maps[i] * rest).squaredNorm();
    if (i < j) sum += 0.5 * kappa * w * (maps[i] - maps[j]).squaredNorm();
  }
  return sum;
}

Mesh Bar() { return MakeCylinder(0.3, 2, 10, 12); }

/// Point pulls at the ends and plane pulls between them. The goals bend and stretch the mesh, which
/// no rigid motion can do.
Pulls MixedPulls(const Mesh& mesh) {
  Pulls pulls(mesh.vertex_count());
  for (int v = 0; v < mesh.vertex_count(); v += 7) {
    const Eigen::Vector3d p = mesh.points.row(v),
                          goal(p.x() + 0.4 * p.z() * p.z(), p.y(), 1.2 * p.z());
    if (v % 2 == 0)
      pulls.AddPoint(v, 1 + 0.1 * v, goal);
    else
      pulls.AddPlane(v, 3, Eigen::Vector3d(1, v % 5, -1).normalized(), goal);
  }
  return pulls;
}

TEST(Pulls, AreTheQuadraticsTheyClaimToBe) {
  Pulls pulls(2);
  const Eigen::Vector3d goal(1, -2, 0.5), normal = Eigen::Vector3d(2, 1, -1).normalized(),
                                          x(0.3, 0.8, -0.4);
  pulls.AddPoint(0, 2.5, goal);
  pulls.AddPlane(0, 4, normal, goal);
  PointsX3 at_x(2, 3), at_goal(2, 3);
  at_x << x.transpose(), Eigen::RowVector3d::Zero();
  at_goal << goal.transpose(), Eigen::RowVector3d::Zero();
  const double expected = 2.5 * (x - goal).squaredNorm() + 4 * std::pow(normal.dot(x - goal), 2);
  EXPECT_NEAR(PullEnergy(pulls, at_x) - PullEnergy(pulls, at_goal), expected, 1e-12);
  EXPECT_NEAR(pulls.MeanWeights()[0], 2.5 + 4.0 / 3, 1e-12);
  EXPECT_EQ(pulls.MeanWeights()[1], 0);
}

TEST(ArapFit, GlobalStepIsTheDenseLeastSquaresSolution) {
  const Mesh mesh = Bar();
  const int n = mesh.vertex_count();
  Eigen::VectorXd stiffness = Eigen::VectorXd::Ones(n);
  for (int v = 0; v < n; ++v) stiffness[v] = mesh.points(v, 2) < 1 ? 5 : 1;
  ArapFit fit(mesh.points, mesh.faces, stiffness, 0.01);
  std::mt19937 random(3);
  std::vector<Eigen::Matrix3d> maps(n);
  for (Eigen::Matrix3d& map : maps) map = RandomMatrix(random);
  fit.SetMaps(maps);
  const Pulls pulls = MixedPulls(mesh);
  fit.SetWeights(pulls.MeanWeights());
  PointsX3 found = mesh.points;
  for (int k = 0; k < 6; ++k)
    // one call stops at 1e-3 of the initial error
    found = fit.FitPositions(pulls, found, 300);

  Eigen::MatrixXd h = Eigen::MatrixXd::Zero(3 * n, 3 * n);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(3 * n);
  for (const auto& [edge, w] : Weights(mesh, stiffness)) {
    const auto& [i, j] = edge;
    const Eigen::Vector3d goal = maps[i] * (mesh.points.row(i) - mesh.points.row(j)).transpose();
    for (int d = 0; d < 3; ++d) {
      const int a = 3 * i + d, b = 3 * j + d;
      h(a, a) += w / 2, h(b, b) += w / 2, h(a, b) -= w / 2, h(b, a) -= w / 2;
      g[a] += w / 2 * goal[d], g[b] -= w / 2 * goal[d];
    }
  }
  for (int i = 0; i < n; ++i) {
    h.block<3, 3>(3 * i, 3 * i) += pulls.q[i];
    g.segment<3>(3 * i) += pulls.b.row(i).transpose();
  }
  const Eigen::VectorXd truth = h.ldlt().solve(g);
  for (int i = 0; i < n; ++i)
    EXPECT_LT((found.row(i).transpose() - truth.segment<3>(3 * i)).norm(), 1e-8 * truth.norm())
        << "vertex " << i;
}

TEST(ArapFit, RigidMotionOfAFewVerticesMovesAllRigidly) {
  const Mesh mesh = Bar();
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(2.5, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  const Eigen::RowVector3d shift(3, -1, 2);
  const PointsX3 truth = (mesh.points * turn.transpose()).rowwise() + shift;
  ArapFit fit(mesh.points, mesh.faces, {}, 0.01);
  Pulls pulls(mesh.vertex_count());
  for (int v : {0, 5, 33, 71, 100, 118}) pulls.AddPoint(v, 10, truth.row(v));
  fit.SetWeights(pulls.MeanWeights());
  PointsX3 p = mesh.points;
  for (int k = 0; k < 3000 && (p - truth).cwiseAbs().maxCoeff() > 1e-9; ++k) {
    p = fit.FitPositions(pulls, p, 1);
    fit.FitMaps(p);
  }
  EXPECT_LT((p - truth).cwiseAbs().maxCoeff(), 1e-8);
  EXPECT_LT((fit.maps()[50] - turn).norm(), 1e-6);
  EXPECT_LT(fit.Strain(p).maxCoeff(), 1e-12);
}

TEST(ArapFit, EnergyFallsWithEveryHalfTurn) {
  const Mesh mesh = Bar();
  for (const double kappa : {0.0, 0.003}) {
    const auto c = Weights(mesh);
    ArapFit fit(mesh.points, mesh.faces, {}, kappa);
    const Pulls pulls = MixedPulls(mesh);
    fit.SetWeights(pulls.MeanWeights());
    PointsX3 p = mesh.points;
    double energy = Energy(mesh, c, kappa, fit.maps(), p, pulls);
    const double first = energy;
    for (int k = 0; k < 40; ++k) {
      p = fit.FitPositions(pulls, p, 10);
      const double after_positions = Energy(mesh, c, kappa, fit.maps(), p, pulls);
      EXPECT_LE(after_positions, energy + 1e-9) << "positions, turn " << k;
      fit.FitMaps(p);
      energy = Energy(mesh, c, kappa, fit.maps(), p, pulls);
      EXPECT_LE(energy, after_positions + 1e-9) << "maps, turn " << k;
    }
    EXPECT_LT(energy, first - 1);
  }
}

TEST(ArapFit, NothingPullsFurtherAtTheSolution) {
  const Mesh mesh = Bar();
  const double kappa = 0.003;
  ArapFit fit(mesh.points, mesh.faces, {}, kappa);
  const Pulls pulls = MixedPulls(mesh);
  fit.SetWeights(pulls.MeanWeights());
  PointsX3 p = mesh.points;
  for (int k = 0; k < 4000; ++k) {
    const PointsX3 before = p;
    p = fit.FitPositions(pulls, p, 10);
    fit.FitMaps(p);
    if ((p - before).cwiseAbs().maxCoeff() < 1e-9) break;
  }
  const auto c = Weights(mesh);
  const double h = 1e-4;
  for (int v = 0; v < mesh.vertex_count(); v += 5)
    for (int d = 0; d < 3; ++d) {
      PointsX3 a = p, b = p;
      a(v, d) += h, b(v, d) -= h;
      EXPECT_NEAR((Energy(mesh, c, kappa, fit.maps(), a, pulls) -
                   Energy(mesh, c, kappa, fit.maps(), b, pulls)) /
                      (2 * h),
                  0, 2e-5)
          << v << ' ' << d;
      // Maps can only rotate, so the energy is stationary under infinitesimal rotations of each.
      std::vector<Eigen::Matrix3d> turned = fit.maps(), back = turned;
      turned[v] = Eigen::AngleAxisd(h, Eigen::Vector3d::Unit(d)) * turned[v];
      back[v] = Eigen::AngleAxisd(-h, Eigen::Vector3d::Unit(d)) * back[v];
      EXPECT_NEAR(
          (Energy(mesh, c, kappa, turned, p, pulls) - Energy(mesh, c, kappa, back, p, pulls)) /
              (2 * h),
          0, 2e-5)
          << v << ' ' << d;
    }
}

TEST(ArapFit, SoftMapsTakeAnEvenStretchWithoutStrain) {
  const Mesh mesh = Bar();
  Eigen::Matrix3d stretch = Eigen::Vector3d(0.8, 1.3, 1.1).asDiagonal();
  stretch = Eigen::AngleAxisd(1, Eigen::Vector3d(1, 1, 0).normalized()) * stretch;
  const PointsX3 truth = mesh.points * stretch.transpose();
  ArapFit fit(mesh.points, mesh.faces, {}, 0.01);
  EXPECT_TRUE(fit.rigid());
  for (int k = 0; k < 200; ++k) fit.FitMaps(truth);
  const double rigid = fit.Strain(truth).maxCoeff();
  EXPECT_GT(rigid, 0.01);
  fit.SetRigidity(1e-6);
  EXPECT_FALSE(fit.rigid());
  for (int k = 0; k < 2000; ++k) fit.FitMaps(truth);
  EXPECT_LT(fit.Strain(truth).maxCoeff(), 1e-6);
  EXPECT_LT((fit.maps()[40] - stretch).norm(), 1e-3);
}

TEST(ArapFit, PartsThatNothingPullsAtStayFinite) {
  const Mesh bar = Bar();
  const int n = bar.vertex_count();
  Mesh mesh;
  mesh.points.resize(2 * n + 1, 3);
  mesh.points << bar.points, bar.points.rowwise() + Eigen::RowVector3d(4, 0, 0),
      Eigen::RowVector3d(9, 9, 9);  // the last is unused
  mesh.faces.resize(2 * bar.faces.rows(), 3);
  mesh.faces << bar.faces, (bar.faces.array() + n).matrix();
  ArapFit fit(mesh.points, mesh.faces, {}, 0.01);
  Pulls pulls(2 * n + 1);
  for (int v = 0; v < n; v += 9)
    pulls.AddPoint(v, 1, bar.points.row(v).transpose() + Eigen::Vector3d(0, 5, 0));
  fit.SetWeights(pulls.MeanWeights());
  PointsX3 p = mesh.points;
  for (int k = 0; k < 100; ++k) {
    p = fit.FitPositions(pulls, p, 10);
    fit.FitMaps(p);
  }
  ASSERT_TRUE(p.allFinite());
  EXPECT_LT(
      (p.topRows(n) - (bar.points.rowwise() + Eigen::RowVector3d(0, 5, 0))).cwiseAbs().maxCoeff(),
      1e-3);
  EXPECT_LT((p.bottomRows(n + 1) - mesh.points.bottomRows(n + 1)).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(ArapFit, FindsTheScaleAndTakesIt) {
  const Mesh mesh = Bar();
  ArapFit fit(mesh.points, mesh.faces, {}, 0.01);
  const PointsX3 grown = 1.7 * mesh.points;
  fit.FitMaps(grown);
  EXPECT_NEAR(fit.BestScale(grown), 1.7, 1e-12);
  fit.ScaleRest(1.7);
  fit.FitMaps(grown);
  EXPECT_NEAR(fit.BestScale(grown), 1, 1e-12);
  EXPECT_LT(fit.Strain(grown).maxCoeff(), 1e-20);
}

TEST(ArapFit, VertexAreasSumToTheSurface) {
  const Mesh mesh = MakeBox(1, 2, 3);
  EXPECT_NEAR(ArapFit(mesh.points, mesh.faces, {}, 0).vertex_areas().sum(), 22, 1e-12);
}

TEST(ArapFit, SameBitsAtOneAndTwoThreads) {
  const Mesh mesh = MakeCylinder(0.3, 2, 40, 80);  // several blocks of work
  std::vector<PointsX3> results;
  for (const int threads : {1, 2}) {
    SetThreadCount(threads);
    ArapFit fit(mesh.points, mesh.faces, {}, 0.01);
    const Pulls pulls = MixedPulls(mesh);
    fit.SetWeights(pulls.MeanWeights());
    PointsX3 p = mesh.points;
    for (int k = 0; k < 3; ++k) {
      p = fit.FitPositions(pulls, p, 10);
      fit.FitMaps(p);
    }
    results.push_back(p);
  }
  SetThreadCount(0);
  EXPECT_EQ(results[0], results[1]);
}

TEST(ArapFit, WithoutAFactorAStartCloseByComesAsFar) {
  // A ripple on a tube whose bend is already right, as after a fit on a coarser mesh.
  const Mesh tube = MakeCylinder(0.3, 2, 60, 80);
  const auto bent = [](const PointsX3& points) {
    PointsX3 b = points;
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      const double a = points(i, 2) * 0.7, r = 1 / 0.7 - points(i, 0);
      b.row(i) << 1 / 0.7 - r * std::cos(a), points(i, 1), r * std::sin(a);
    }
    return b;
  };
  const PointsX3 goal = bent(tube.points);
  PointsX3 start = goal;
  for (Eigen::Index i = 0; i < start.rows(); ++i)
    start(i, 1) += 0.01 * std::sin(40 * tube.points(i, 2)) * tube.points(i, 1);
  Pulls pulls(start.rows());
  for (Eigen::Index i = 0; i < start.rows(); ++i) {
    const Eigen::Vector3d normal = Eigen::Vector3d(goal(i, 0) - 0.3, goal(i, 1), 0.1).normalized();
    pulls.AddPlane(i, 0.05, normal, goal.row(i));
    pulls.AddPoint(i, 0.002, goal.row(i));
  }
  PointsX3 ends[2];
  for (const bool factor : {true, false}) {
    ArapFit fit(tube.points, tube.faces, {}, 0.001, factor);
    PointsX3 moved = start;
    fit.FitMaps(moved);
    fit.SetWeights(pulls.MeanWeights());
    for (int turn = 0; turn < 4; ++turn) {
      moved = fit.FitPositions(pulls, moved, 10);
      fit.FitMaps(moved);
    }
    ends[factor] = moved;
  }
  const double left = (ends[0] - ends[1]).rowwise().norm().maxCoeff(),
               made = (ends[1] - start).rowwise().norm().maxCoeff();
  EXPECT_GT(made, 0.002);
  EXPECT_LT(left, 0.15 * made);

  ArapFit fit(tube.points, tube.faces, {}, 0.001, false);
  fit.SetWeights(pulls.MeanWeights());
  SetThreadCount(1);
  const PointsX3 one = fit.FitPositions(pulls, start, 10);
  SetThreadCount(2);
  EXPECT_EQ(one, fit.FitPositions(pulls, start, 10));
  SetThreadCount(0);
}

}  // namespace keypose::arap_fit_test
