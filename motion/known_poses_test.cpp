// Transfers on a rigged character whose poses are known.
#include <gtest/gtest.h>

#include <optional>

#include "core/surfaces/geometry.h"
#include "motion/testing/rigged_scan.h"
#include "motion/transfer.h"

namespace keypose::motion::known_poses_test {

std::vector<PointsX3> TransferredBy(const RiggedScan& scan, TransferMethod method) {
  TransferOptions options;
  options.method = method;
  options.feet = false;
  Transfer transfer(scan.target, scan.reference, scan.faces, scan.marks, options);
  for (const PointsX3& frame : scan.frames) transfer.Add(frame, "frame");
  std::vector<PointsX3> poses;
  transfer.Run([&](int, const PointsX3& points) { poses.push_back(points); });
  return poses;
}

TEST(KnownPoses, AutoIsNearerThanThePaperAndThanSkinningByTheNearestMark) {
  const std::optional<RiggedScan> scan = LoadRiggedScan(40);
  if (!scan) GTEST_SKIP() << "motion/rigs/cheburashka is not here; set KEYPOSE_DATA";
  ASSERT_EQ(scan->poses.size(), 16u);
  const PoseError own = ErrorOf(*scan, TransferredBy(*scan, TransferMethod::kAuto)),
                  paper = ErrorOf(*scan, TransferredBy(*scan, TransferMethod::kPaper)),
                  skinned = ErrorOf(*scan, NearestMarkSkinning(*scan));
  EXPECT_LT(own.mean, paper.mean);
  EXPECT_LT(own.mean, skinned.mean);
}

TEST(KnownPoses, LiteralAndFastAgree) {
  const std::optional<RiggedScan> scan = LoadRiggedScan(40);
  if (!scan) GTEST_SKIP() << "motion/rigs/cheburashka is not here; set KEYPOSE_DATA";
  const auto fast = TransferredBy(*scan, TransferMethod::kPaper),
             literal = TransferredBy(*scan, TransferMethod::kLiteral);
  const double diagonal = BoundingDiagonal(scan->target.points);
  for (std::size_t t = 0; t < fast.size(); ++t)
    EXPECT_LT((fast[t] - literal[t]).rowwise().norm().maxCoeff(), 1e-10 * diagonal);
}

}  // namespace keypose::motion::known_poses_test
