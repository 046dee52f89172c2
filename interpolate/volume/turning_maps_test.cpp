// The maps of single tetrahedra: rotations, powers, paths, and turns beyond a half.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "interpolate/maps/face_maps.h"
#include "interpolate/maps/matrix_powers.h"
#include "interpolate/testing/bars.h"
#include "interpolate/volume/graph_turns.h"
#include "interpolate/volume/tet_maps.h"
#include "interpolate/volume/tet_paths.h"

namespace keypose::interpolation::turning_maps_test {

TEST(ClosestRotation, EqualsSingularValuesAlsoForMirroredAndFlatMaps) {
  for (int k = 0; k < 2000; ++k) {
    const auto wave = [&](double f) { return std::sin(f * (k + 1)); };
    Eigen::Matrix3d j;
    j << wave(1.1), wave(2.3), wave(3.7), wave(0.9), wave(5.1), wave(1.7), wave(2.9), wave(4.3),
        wave(0.7);
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(Eigen::MatrixXd(j),
                                                Eigen::ComputeFullU | Eigen::ComputeFullV);
    if (svd.singularValues()[1] - svd.singularValues()[2] < 1e-3)
      continue;  // not unique for a mirrored one
    Eigen::Vector3d sign = Eigen::Vector3d::Ones();
    sign[2] = (svd.matrixU() * svd.matrixV()).determinant() > 0 ? 1 : -1;
    EXPECT_LT(
        (ClosestRotation(j) - svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose()).norm(),
        1e-10);
  }
  EXPECT_LT(
      (ClosestRotation(Eigen::Vector3d(2, 3, 0).asDiagonal()) - Eigen::Matrix3d::Identity()).norm(),
      1e-12);
}

TEST(LogOfMatrix, IsTheInverseOfTheExponentialAndKnowsShears) {
  for (int k = 0; k < 500; ++k) {
    const auto wave = [&](double f) { return 0.8 * std::sin(f * (k + 1)); };
    Eigen::Matrix3d log;
    log << wave(1.1), wave(2.3), wave(3.7), wave(0.9), wave(5.1), wave(1.7), wave(2.9), wave(4.3),
        wave(0.7);
    const std::optional<Eigen::Matrix3d> back = LogOfMatrix(ExpOfMatrix(log));
    ASSERT_TRUE(back.has_value());
    EXPECT_LT((*back - log).norm(), 1e-11);
    for (double t : {-1.3, 0.1, 0.7, 3.0})
      EXPECT_LT((MatrixExponential(log).At(t) - ExpOfMatrix(t * log)).norm(),
                1e-13 * ExpOfMatrix(t * log).norm());
  }
  Eigen::Matrix3d shear = Eigen::Matrix3d::Identity();
  shear(0, 2) = 5;
  EXPECT_LT((*LogOfMatrix(shear) - (shear - Eigen::Matrix3d::Identity())).norm(), 1e-12);
  EXPECT_FALSE(LogOfMatrix(-Eigen::Matrix3d::Identity()).has_value());
}

TEST(TetPath, AShearStaysAShearAndABendedFibreGrowsEvenly) {
  Eigen::Matrix3d shear = Eigen::Matrix3d::Identity();
  shear(0, 2) = 2;
  const Eigen::Vector3d turn(0, 0, 3);
  Eigen::Matrix3d quarter = Eigen::Matrix3d::Identity();
  quarter(0, 2) = 0.5;
  EXPECT_LT((TetPath(ExpOf(turn) * shear, turn, 0).At(0.25) - ExpOf(0.25 * turn) * quarter).norm(),
            1e-12);
  const Eigen::Matrix3d fibre = Eigen::Vector3d(1, 1, 0.4).asDiagonal(),
                        half = Eigen::Vector3d(1, 1, 0.7).asDiagonal();
  EXPECT_LT((TetPath(ExpOf(turn) * fibre, turn, 0).At(0.5) - ExpOf(0.5 * turn) * half).norm(),
            1e-12);
}

TEST(TetPath, ReachesWhatHasNoLogarithm) {
  for (const Eigen::Vector3d& stretch : {Eigen::Vector3d(1, 2, -0.5), Eigen::Vector3d(1, 2, 0)}) {
    const Eigen::Matrix3d map = Turn(3, {1, 1, 0}) * stretch.asDiagonal();
    const TetPath path(map, {0.1, 0.2, 0.3}, 0.1);
    EXPECT_FALSE(path.has_power());
    EXPECT_LT((path.At(0) - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    EXPECT_LT((path.At(1) - map).norm(), 1e-12);
  }
}

TEST(LiftTurns, AChainThatCoilsNearlyThreeTimesIsOneLongTurn) {
  std::vector<Eigen::Matrix3d> rotations;
  std::vector<std::array<int, 4>> neighbours;
  const int count = 101;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d wobble(0.03 * std::sin(7.0 * i), 0.03 * std::cos(5.0 * i), 0);
    rotations.push_back(Turn(i * 10 * kPi / 180, Eigen::Vector3d::UnitZ()) * ExpOf(wobble));
    neighbours.push_back({i > 0 ? i - 1 : -1, i + 1 < count ? i + 1 : -1, -1, -1});
  }
  const LiftedTurns lifted = LiftTurns(rotations, 0, neighbours, std::vector<char>(count, 0));
  for (int i = 0; i < count; ++i) {
    EXPECT_NEAR(lifted.turns[i].norm(), i * 10 * kPi / 180, 0.1) << i;
    EXPECT_LT((ExpOf(lifted.turns[i]) * ExpOf(lifted.remainders[i]) - rotations[i]).norm(), 1e-12);
    EXPECT_LT(lifted.remainders[i].norm(), 0.2);
  }
  EXPECT_LT(lifted.largest_tear, 1);
}

TEST(LiftTurns, ARingThatTurnedInsideItselfIsReportedAsTorn) {
  std::vector<Eigen::Matrix3d> rotations;
  std::vector<std::array<int, 4>> neighbours;
  for (int i = 0; i < 36; ++i) {
    rotations.push_back(Turn(i * 10 * kPi / 180, Eigen::Vector3d::UnitX()));
    neighbours.push_back({(i + 35) % 36, (i + 1) % 36, -1, -1});
  }
  EXPECT_NEAR(LiftTurns(rotations, 0, neighbours, std::vector<char>(36, 0)).largest_tear, 2 * kPi,
              0.5);
}

}  // namespace keypose::interpolation::turning_maps_test
