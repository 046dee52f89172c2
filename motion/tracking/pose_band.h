// Least squares over the poses of a sequence, where each frame is tied to its next neighbours only.
#pragma once

#include <array>
#include <vector>

#include "motion/tracking/pose_prior.h"

namespace keypose::motion {

/// A symmetric, positive definite system of 38 unknowns a frame, in blocks about the diagonal.
class PoseBand {
 public:
  static constexpr int kReach = 3;  ///< frames to each side that a frame is tied to

  explicit PoseBand(int frames);
  int frames() const { return static_cast<int>(blocks_.size()); }
  /// The block of frame `frame + later` by frame `frame`; later from 0 to kReach.
  DofMatrix& Block(int frame, int later) { return blocks_[frame][later]; }

  /// Solves for one right side; the blocks are then their Cholesky factor.
  /// @return 38 numbers a frame; not finite when the system is not positive definite
  /// Cost: 0.9 million multiplications and 46 kB a frame.
  std::vector<DofVector> Solve(std::vector<DofVector> right);

 private:
  void Factor();

  std::vector<std::array<DofMatrix, kReach + 1>> blocks_;
};

}  // namespace keypose::motion
