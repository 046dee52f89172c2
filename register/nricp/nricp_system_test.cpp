#include "register/nricp/nricp_system.h"

#include <iterator>

#include <gtest/gtest.h>
#include <Eigen/Dense>

#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"

namespace keypose::registration::nricp_system_test {

using Eigen::MatrixXd;

/// Smooth artificial numbers, the same on every machine.
MatrixXd Waves(Eigen::Index rows, Eigen::Index cols, double phase) {
  MatrixXd m(rows, cols);
  for (Eigen::Index i = 0; i < rows; ++i)
    for (Eigen::Index j = 0; j < cols; ++j) m(i, j) = std::sin(1.7 * i + 2.3 * j + phase);
  return m;
}

struct Scene {
  Mesh mesh = MakeIcosphere(1);  // 42 vertices
  std::vector<SurfacePoint> marks;
  Eigen::VectorXd stiffness;
  NricpTerms terms;

  Scene() {
    const int n = mesh.vertex_count();
    marks = {{{3, 3, 3}, {1, 0, 0}},
             {mesh.faces.row(5).transpose(), {0.2, 0.5, 0.3}},
             {mesh.faces.row(40).transpose(), {0.5, 0.5, 0}}};
    stiffness = Eigen::VectorXd::Constant(n, 1.0) + 0.5 * Waves(n, 1, 0.4);
    terms.alpha = 1.3;
    terms.gamma = 0.7;
    terms.beta = 2.1;
    terms.weights = Eigen::VectorXd::Ones(n);
    for (int i = 0; i < n; i += 3) terms.weights[i] = 0;
    terms.closest = mesh.points + 0.3 * Waves(n, 3, 1.0);
    terms.landmarks = PointsX3::Constant(3, 3, 0.4) + 0.5 * Waves(3, 3, 2.0);
  }
};

/// A and B of E = |A X - B|^2 as dense matrices, exactly as written in the paper.
void DenseRows(const Scene& s, MatrixXd& a, MatrixXd& b) {
  const auto edges = UndirectedEdges(s.mesh.faces);
  const Eigen::Index n = s.mesh.vertex_count(), e = std::ssize(edges), l = std::ssize(s.marks);
  a = MatrixXd::Zero(4 * e + n + l, 4 * n);
  b = MatrixXd::Zero(a.rows(), 3);
  for (Eigen::Index k = 0; k < e; ++k)
    for (int r = 0; r < 4; ++r) {
      const double m = std::sqrt(s.stiffness[edges[k].first] * s.stiffness[edges[k].second]);
      const double g = s.terms.alpha * m * (r == 3 ? s.terms.gamma : 1);
      a(4 * k + r, 4 * edges[k].first + r) = -g;
      a(4 * k + r, 4 * edges[k].second + r) = g;
    }
  for (Eigen::Index i = 0; i < n; ++i) {
    a.block<1, 4>(4 * e + i, 4 * i) << s.terms.weights[i] * s.mesh.points.row(i),
        s.terms.weights[i];
    b.row(4 * e + i) = s.terms.weights[i] * s.terms.closest.row(i);
  }
  for (Eigen::Index k = 0; k < l; ++k) {
    for (int c = 0; c < 3; ++c) {
      const int i = s.marks[k].vertices[c];
      Eigen::RowVector4d v;
      v << s.mesh.points.row(i), 1;
      a.block<1, 4>(4 * e + n + k, 4 * i) += s.terms.beta * s.marks[k].weights[c] * v;
    }
    b.row(4 * e + n + k) = s.terms.beta * s.terms.landmarks.row(k);
  }
}

TEST(NricpSystem, EqualsDenseQrOfThePapersRows) {
  const Scene s;
  NricpSystem system(s.mesh.points, s.mesh.faces, s.marks, s.stiffness);
  system.Refill(s.terms, system.Identity());
  MatrixXd a, b;
  DenseRows(s, a, b);
  const MatrixXd oracle = a.colPivHouseholderQr().solve(b), x = system.SolveDirect();
  EXPECT_LT((x - oracle).cwiseAbs().maxCoeff(), 1e-8);
  EXPECT_NEAR(system.Energy(x), (a * oracle - b).squaredNorm(), 1e-9);
}

TEST(NricpSystem, GradientEqualsFiniteDifferences) {
  const Scene s;
  NricpSystem system(s.mesh.points, s.mesh.faces, s.marks, s.stiffness);
  system.Refill(s.terms, system.Identity());
  const MatrixXd x = system.Identity() + 0.2 * Waves(4 * s.mesh.vertex_count(), 3, 3.0),
                 g = system.HalfGradient(x);
  for (int row = 0; row < x.rows(); row += 7)
    for (int col = 0; col < 3; ++col) {
      MatrixXd up = x, down = x;
      // the energy is quadratic, so central differences are exact up to rounding
      up(row, col) += 1e-3;
      down(row, col) -= 1e-3;
      EXPECT_NEAR((system.Energy(up) - system.Energy(down)) / 4e-3, g(row, col),
                  1e-6 * (1 + std::abs(g(row, col))));
    }
}

TEST(NricpSystem, AffineImageIsFoundExactlyAtAnyStiffness) {
  Scene s;
  MatrixXd map(4, 3);
  map << 1.2, 0.1, 0, -0.3, 0.9, 0.2, 0.1, 0, 1.1, 0.5, -0.2, 0.3;
  for (Eigen::Index i = 0; i < s.mesh.vertex_count(); ++i) {
    Eigen::RowVector4d v;
    v << s.mesh.points.row(i), 1;
    s.terms.closest.row(i) = v * map;
  }
  s.terms.beta = 0;
  for (double alpha : {50.0, 1.0, 0.2}) {
    s.terms.alpha = alpha;
    NricpSystem system(s.mesh.points, s.mesh.faces, s.marks);
    system.Refill(s.terms, system.Identity());
    const MatrixXd x = system.SolveDirect();
    EXPECT_LT((system.Deformed(x) - s.terms.closest).cwiseAbs().maxCoeff(), 1e-9);
    for (int i = 0; i < s.mesh.vertex_count(); ++i)
      EXPECT_LT((x.middleRows<4>(4 * i) - map).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(NricpSystem, EnergyNeverRisesBySolving) {
  const Scene s;
  NricpSystem system(s.mesh.points, s.mesh.faces, s.marks, s.stiffness);
  MatrixXd x = system.Identity();
  NricpTerms terms = s.terms;
  for (double alpha : {50.0, 5.0, 0.5, 0.1}) {
    terms.alpha = alpha;
    system.Refill(terms, x);
    const double before = system.Energy(x);
    x = system.SolveDirect();
    EXPECT_LE(system.Energy(x), before * (1 + 1e-12));
    EXPECT_LT(system.HalfGradient(x).norm(), 1e-9 * before);
  }
  EXPECT_EQ(system.analyses(), 1);
  EXPECT_EQ(system.factorisations(), 4);
}

TEST(NricpSystem, GradientsOnTheLastFactorReachTheDirectSolution) {
  const Scene s;
  NricpSystem system(s.mesh.points, s.mesh.faces, s.marks, s.stiffness);
  system.Refill(s.terms, system.Identity());
  const MatrixXd first = system.SolveDirect();
  NricpTerms softer = s.terms;
  softer.alpha /= 1.6;
  softer.weights[1] = 0;
  system.Refill(softer, first);
  const MatrixXd near = system.SolveNear(first, 1e-11, 60);
  EXPECT_EQ(system.factorisations(), 1);
  EXPECT_GT(system.pcg_steps(), 0);
  EXPECT_LT((near - system.SolveDirect()).cwiseAbs().maxCoeff(), 1e-8);
  softer.alpha /= 3;
  system.Refill(softer, first);
  system.SolveNear(first, 1e-13, 2);  // cannot be reached in two steps
  EXPECT_EQ(system.factorisations(), 3);
}

TEST(NricpSystem, PartThatNothingHoldsStaysWhereItIs) {
  const Mesh one = MakeIcosphere(1);
  const int n = one.vertex_count();
  PointsX3 points(2 * n + 1, 3);
  points << one.points, (one.points.rowwise() + Eigen::RowVector3d(4, 0, 0)),
      Eigen::RowVector3d(9, 9, 9);  // the last vertex is in no face
  FacesX3 faces(2 * one.face_count(), 3);
  faces << one.faces, (one.faces.array() + n).matrix();
  NricpTerms terms;
  terms.weights = Eigen::VectorXd::Zero(2 * n + 1);
  terms.weights.head(n).setOnes();
  terms.weights[n] = 1;  // one correspondence cannot fix twelve numbers either
  terms.closest = points;
  terms.closest.topRows(n).col(2).array() += 0.1;
  terms.landmarks.resize(0, 3);
  NricpSystem system(points, faces, {});
  system.Refill(terms, system.Identity());
  const PointsX3 moved = system.Deformed(system.SolveDirect());
  EXPECT_EQ(system.loose_components(), 2);
  EXPECT_LT((moved.topRows(n) - terms.closest.topRows(n)).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_LT((moved.bottomRows(n + 1) - points.bottomRows(n + 1)).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(NricpSystem, StiffnessOfAnotherMeshThrows) {
  const Mesh mesh = MakeIcosphere(0);
  EXPECT_THROW(NricpSystem(mesh.points, mesh.faces, {}, Eigen::VectorXd::Ones(5)), InputError);
}

}  // namespace keypose::registration::nricp_system_test
