#include "motion/tracking/pose_band.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "motion/tracking/testing/wandering.h"

namespace keypose::motion::pose_band_test {

TEST(PoseBand, SolvesAsADenseFactorDoes) {
  Noise noise(1);
  const int frames = 5, n = frames * kDofs;
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(n, n);
  PoseBand band(frames);
  for (int f = 0; f < frames; ++f)
    for (int later = 0; later <= std::min(PoseBand::kReach, frames - 1 - f); ++later) {
      DofMatrix block;
      for (double& x : block.reshaped()) x = 0.1 * noise.Draw();
      if (later == 0) block = (block * block.transpose() + 5 * DofMatrix::Identity()).eval();
      band.Block(f, later) = block;
      dense.block<kDofs, kDofs>((f + later) * kDofs, f * kDofs) = block;
      dense.block<kDofs, kDofs>(f * kDofs, (f + later) * kDofs) = block.transpose();
    }
  std::vector<DofVector> right;
  Eigen::VectorXd all(n);
  for (int f = 0; f < frames; ++f)
    right.push_back(noise.Numbers()), all.segment<kDofs>(f * kDofs) = right[f];
  const Eigen::VectorXd expected = dense.llt().solve(all);
  const std::vector<DofVector> solved = band.Solve(right);
  for (int f = 0; f < frames; ++f)
    EXPECT_LT((solved[f] - expected.segment<kDofs>(f * kDofs)).cwiseAbs().maxCoeff(), 1e-12);
}

}  // namespace keypose::motion::pose_band_test
