// Pins, paths, springs and the floor.
#include "interpolate/surface/key_constraints.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"
#include "interpolate/surface/arap.h"

namespace keypose::interpolation::constraints_test {

constexpr double kLength = 2;

PointsX3 Bent(const PointsX3& points, double degrees) {
  PointsX3 bent = points;
  const double radius = kLength / (degrees * std::numbers::pi / 180);
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const double a = points(i, 2) / radius, r = radius - points(i, 0);
    bent.row(i) << radius - r * std::cos(a), points(i, 1), r * std::sin(a);
  }
  return bent;
}

struct Tube {
  Mesh mesh = MakeCylinder(0.15, kLength, 12, 30);
  PointsX3 end = Bent(mesh.points, 150);
  double diagonal = BoundingDiagonal(end);

  std::vector<int> Between(double low, double high) const {
    std::vector<int> vertices;
    for (int i = 0; i < mesh.vertex_count(); ++i)
      if (mesh.points(i, 2) >= low && mesh.points(i, 2) <= high) vertices.push_back(i);
    return vertices;
  }
  ArapInterpolator With(const Constraints& constraints) const {
    ArapOptions options;
    options.constraints = constraints;
    return ArapInterpolator(mesh.points, end, mesh.faces, options);
  }
  double OffVolumePath(const PointsX3& frame, double t) const {
    const double v0 = SignedVolume(mesh.points, mesh.faces), v1 = SignedVolume(end, mesh.faces);
    return std::abs(SignedVolume(frame, mesh.faces) / (std::pow(v0, 1 - t) * std::pow(v1, t)) - 1);
  }
};

TEST(Constraints, PinnedPatchStaysWhileVolumeFollows) {
  const Tube tube;
  const std::vector<int> foot = tube.Between(-1, 0.2);
  const ArapInterpolator arap =
      tube.With({.patches = {{.name = "foot", .vertices = foot}}, .floor = {}});
  for (double t : {0.25, 0.5, 0.9}) {
    const PointsX3 frame = arap.At(t);
    for (int i : foot)
      EXPECT_LT((frame.row(i) - ((1 - t) * tube.mesh.points.row(i) + t * tube.end.row(i))).norm(),
                1e-12 * tube.diagonal);
    EXPECT_LT(tube.OffVolumePath(frame, t), 1e-10);
  }
  EXPECT_EQ(arap.At(0), tube.mesh.points);
  EXPECT_EQ(arap.At(1), tube.end);
}

TEST(Constraints, CentroidFollowsItsPathAndTheRestFollowsIt) {
  const Tube tube;
  const std::vector<int> tip = tube.Between(1.8, 3);
  PatchConstraint hand{.name = "hand", .vertices = tip, .hold = PatchConstraint::Hold::kCentroid};
  hand.path = [](double t) { return Eigen::Vector3d(1 + t, std::sin(3 * t), 2); };
  ArapOptions options;
  // its field is projected in another way where a row holds the body
  options.correct_volume = false;
  const PointsX3 free =
      ArapInterpolator(tube.mesh.points, tube.end, tube.mesh.faces, options).At(0.3);
  options.constraints.patches = {hand};
  const PointsX3 frame =
      ArapInterpolator(tube.mesh.points, tube.end, tube.mesh.faces, options).At(0.3);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (int i : tip) mean += frame.row(i).transpose() / static_cast<double>(tip.size());
  EXPECT_LT((mean - hand.path(0.3)).norm(), 1e-12);
  // A single centroid only moves the body: the shapes are those without it.
  const Eigen::RowVector3d shift = frame.row(0) - free.row(0);
  EXPECT_LT((frame - (free.rowwise() + shift)).rowwise().norm().maxCoeff(), 1e-9);
}

TEST(Constraints, MultipliersGiveTheLeastEnergy) {
  // Any change that satisfies the rows raises the energy: the residual H x - G is a combination of
  // the rows.
  const Tube tube;
  const std::vector<int> foot = tube.Between(-1, 0.1), tip = tube.Between(1.9, 3);
  Constraints constraints{
      .patches = {{.name = "foot", .vertices = foot}, {.name = "tip", .vertices = tip}},
      .floor = {}};
  const PoissonSystem system({tube.mesh.points, tube.end}, tube.mesh.faces,
                             RowsOf(constraints, tube.mesh.vertex_count()));
  EdgeBatch edges(tube.mesh.faces.rows(), 1);
  for (Eigen::Index f = 0; f < tube.mesh.faces.rows(); ++f) {
    Eigen::Matrix<double, 3, 2> wanted;
    for (int k = 0; k < 2; ++k)
      wanted.col(k) = tube.mesh.points.row(tube.mesh.faces(f, k + 1)) -
                      tube.mesh.points.row(tube.mesh.faces(f, 0));
    edges.Set(f, 0, wanted);
  }
  const PointsX3 x =
      system.Solve(edges, {TargetsOf(constraints, tube.mesh.points, tube.end, 0.5)})[0];
  const auto energy = [&](const PointsX3& p) {
    double sum = 0;
    for (const PointsX3& key : {tube.mesh.points, tube.end})
      for (Eigen::Index f = 0; f < tube.mesh.faces.rows(); ++f)
        for (int k = 0; k < 3; ++k) {
          const int a = tube.mesh.faces(f, k), b = tube.mesh.faces(f, (k + 1) % 3),
                    c = tube.mesh.faces(f, (k + 2) % 3);
          const Eigen::RowVector3d u = key.row(a) - key.row(c), w = key.row(b) - key.row(c);
          sum += 0.5 * u.dot(w) / u.cross(w).norm() *
                 ((p.row(b) - p.row(a)) - (tube.mesh.points.row(b) - tube.mesh.points.row(a)))
                     .squaredNorm();
        }
    return sum;
  };
  PointsX3 push = PointsX3::Zero(x.rows(), 3);
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    push.row(i) << std::sin(1.7 * i), std::cos(2.3 * i), std::sin(0.9 * i + 1);
  for (int i : foot) push.row(i).setZero();
  for (int i : tip) push.row(i).setZero();
  const double h = 1e-4, slope = (energy(x + h * push) - energy(x - h * push)) / (2 * h);
  EXPECT_LT(std::abs(slope), 1e-7);
  EXPECT_GT(energy(x + h * push), energy(x));
}

TEST(Constraints, SpringGivesWayAndStiffensToAPin) {
  const Tube tube;
  const std::vector<int> tip = tube.Between(1.8, 3), foot = tube.Between(-1, 0.2);
  const Eigen::Vector3d goal(3, 1, 1);
  const auto gap = [&](double softness) {
    PatchConstraint spring{
        .name = "tip", .vertices = tip, .hold = PatchConstraint::Hold::kCentroid};
    spring.path = [&](double) { return goal; };
    spring.softness = softness;
    const PointsX3 frame =
        tube.With({.patches = {{.name = "foot", .vertices = foot}, spring}, .floor = {}}).At(0.5);
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (int i : tip) mean += frame.row(i).transpose() / static_cast<double>(tip.size());
    return (mean - goal).norm();
  };
  const double hard = gap(0), stiff = gap(0.01), soft = gap(10);
  EXPECT_LT(hard, 1e-11);
  EXPECT_GT(stiff, 1e-4);
  EXPECT_GT(soft, 5 * stiff);
}

TEST(Constraints, RowsThatFollowFromOthersAreDroppedAndNamed) {
  const Tube tube;
  const std::vector<int> foot = tube.Between(-1, 0.2);
  const Constraints constraints{.patches = {{.name = "foot", .vertices = foot},
                                            {.name = "foot again",
                                             .vertices = foot,
                                             .hold = PatchConstraint::Hold::kCentroid},
                                            {.name = "one", .vertices = {foot[0]}}},
                                .floor = {}};
  const ArapInterpolator arap = tube.With(constraints);
  EXPECT_THAT(arap.report().dropped_constraints,
              ::testing::ElementsAre("foot again", "one, vertex " + std::to_string(foot[0])));
  EXPECT_TRUE(arap.At(0.5).allFinite());
}

TEST(Constraints, UnpinnedBodyIsLiftedToTheFloorAsAWhole) {
  // A box on its face that turns by a quarter ends on another face; half-way its edge would sink.
  const Mesh mesh = MakeBox(1, 1, 1);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const Eigen::RowVector3d centre(0.5, 0.5, 0.5);
  const PointsX3 end = ((mesh.points.rowwise() - centre) * turn.transpose()).rowwise() + centre;
  ArapOptions options;
  EXPECT_NEAR(ArapInterpolator(mesh.points, end, mesh.faces, options).At(0.5).col(2).minCoeff(),
              0.5 - std::sqrt(0.5), 1e-9);
  options.constraints.floor = Floor{};
  const ArapInterpolator arap(mesh.points, end, mesh.faces, options);
  const PointsX3 frame = arap.At(0.5);
  EXPECT_GE(frame.col(2).minCoeff(), -1e-15);
  EXPECT_LT(frame.col(2).minCoeff(), 1e-9);
  for (const auto& [i, j] : UndirectedEdges(mesh.faces))
    EXPECT_NEAR((frame.row(i) - frame.row(j)).norm(),
                (mesh.points.row(i) - mesh.points.row(j)).norm(), 1e-9);
}

TEST(Constraints, PinnedBodyBendsAtTheFloorAndKeepsPinAndVolume) {
  // A tube held at its upper end bends sideways below the table, so its lower end must be lifted.
  Tube tube;
  tube.mesh.points.col(2).array() -= 0.1;  // the first key's foot is 0.1 below zero
  tube.end.col(2).array() -= 0.1;
  const std::vector<int> held = tube.Between(1.6, 3);
  const double floor = -0.05;
  Constraints constraints{.patches = {{.name = "top", .vertices = held}},
                          .floor = Floor{floor, {}}};
  const ArapInterpolator arap = tube.With(constraints);
  std::vector<FrameFacts> facts;
  const double t = 0.05;
  const PointsX3 frame = arap.At({t}, &facts)[0];
  EXPECT_GE(frame.col(2).minCoeff(), floor - 1e-9);
  EXPECT_GT(facts[0].floor_vertices, 3);
  for (int i : held)
    EXPECT_LT((frame.row(i) - ((1 - t) * tube.mesh.points.row(i) + t * tube.end.row(i))).norm(),
              1e-9);
  EXPECT_LT(tube.OffVolumePath(frame, t), 1e-8);
}

TEST(Constraints, SwapAndThreadsChangeNothing) {
  const Tube tube;
  Constraints constraints{.patches = {{.name = "foot", .vertices = tube.Between(-1, 0.2)}},
                          .floor = {}};
  ArapOptions options;
  options.constraints = constraints;
  SetThreadCount(1);
  const PointsX3 there = tube.With(constraints).At(0.3);
  SetThreadCount(2);
  const PointsX3 again = tube.With(constraints).At(0.3);
  SetThreadCount(0);
  EXPECT_EQ(there, again);
  const PointsX3 back =
      ArapInterpolator(tube.end, tube.mesh.points, tube.mesh.faces, options).At(0.7);
  EXPECT_LT((there - back).rowwise().norm().maxCoeff(), 1e-12 * tube.diagonal);
}

TEST(Constraints, BadOnesAreNamed) {
  const Tube tube;
  const auto message = [&](const Constraints& constraints) -> std::string {
    try {
      tube.With(constraints).At(0.5);
    } catch (const InputError& e) {
      return e.what();
    }
    return "no error";
  };
  EXPECT_THAT(message({.patches = {{.name = "empty", .vertices = {}}}, .floor = {}}),
              ::testing::HasSubstr("'empty' has no vertices"));
  EXPECT_THAT(message({.patches = {{.name = "far", .vertices = {99999}}}, .floor = {}}),
              ::testing::HasSubstr("vertex 99999"));
  PatchConstraint lost{.name = "lost", .vertices = {1}};
  lost.path = [](double) {
    return Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()).eval();
  };
  EXPECT_THAT(message({.patches = {lost}, .floor = {}}),
              ::testing::HasSubstr("path of constraint 'lost' is not finite"));
  PatchConstraint soft{.name = "soft", .vertices = {1}};
  soft.softness = -1;
  EXPECT_THAT(message({.patches = {soft}, .floor = {}}), ::testing::HasSubstr("softness"));
  EXPECT_THAT(message({.patches = {{.name = "cellar", .vertices = tube.Between(-1, 0.2)}},
                       .floor = Floor{0.5, {}}}),
              ::testing::HasSubstr("below the floor"));
}

}  // namespace keypose::interpolation::constraints_test
