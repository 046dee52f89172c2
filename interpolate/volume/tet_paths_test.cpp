#include "interpolate/volume/tet_paths.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "core/numbers/rotations.h"
#include "interpolate/testing/bars.h"
#include "interpolate/volume/tet_maps.h"

namespace keypose::interpolation::tet_paths_test {

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

}  // namespace keypose::interpolation::tet_paths_test
