#include "motion/tracking/pose_band.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace keypose::motion {

PoseBand::PoseBand(int frames) : blocks_(static_cast<std::size_t>(frames)) {
  for (auto& row : blocks_) row.fill(DofMatrix::Zero());
}

void PoseBand::Factor() {
  for (int f = 0; f < frames(); ++f) {
    const int last = std::min(kReach, frames() - 1 - f);
    DofMatrix& diagonal = blocks_[f][0];
    diagonal = DofMatrix(Eigen::LLT<DofMatrix>(diagonal).matrixL());
    for (int j = 1; j <= last; ++j)
      diagonal.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(
          blocks_[f][j]);
    for (int i = 1; i <= last; ++i)
      for (int j = i; j <= last; ++j)
        blocks_[f + i][j - i].noalias() -= blocks_[f][j] * blocks_[f][i].transpose();
  }
}

std::vector<DofVector> PoseBand::Solve(std::vector<DofVector> right) {
  Factor();
  for (int f = 0; f < frames(); ++f) {
    blocks_[f][0].triangularView<Eigen::Lower>().solveInPlace(right[f]);
    for (int j = 1; j <= std::min(kReach, frames() - 1 - f); ++j)
      right[f + j].noalias() -= blocks_[f][j] * right[f];
  }
  for (int f = frames() - 1; f >= 0; --f) {
    for (int j = 1; j <= std::min(kReach, frames() - 1 - f); ++j)
      right[f].noalias() -= blocks_[f][j].transpose() * right[f + j];
    blocks_[f][0].triangularView<Eigen::Lower>().transpose().solveInPlace(right[f]);
  }
  return right;
}

}  // namespace keypose::motion
