#include "register/intrinsic/tip_matching.h"

#include <gtest/gtest.h>

#include <vector>

namespace keypose::registration::tip_matching_test {

TEST(MatchTips, FindsThePermutationAndKeepsWhatIsKnown) {
  const int n = 6;
  Eigen::MatrixXd places(n, 2);
  places << 0, 0, 1, 0.1, 2.2, 0.9, 0.4, 1.7, 3.1, 2.0, 1.5, 3.3;
  const std::vector<int> shuffled = {3, 0, 5, 1, 4, 2};  // source tip i is target tip shuffled[i]
  TipProblem problem;
  problem.source_distances.resize(n, n);
  problem.target_distances.resize(n, n);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      problem.source_distances(i, j) = (places.row(i) - places.row(j)).norm();
      problem.target_distances(shuffled[i], shuffled[j]) = problem.source_distances(i, j);
    }
  problem.unlike = Eigen::MatrixXd::Zero(n, n);
  const auto best = MatchTips(problem, 5);
  ASSERT_EQ(best.size(), 5u);
  EXPECT_EQ(best[0].target_of, shuffled);
  for (std::size_t k = 1; k < best.size(); ++k) EXPECT_GE(best[k].score, best[k - 1].score);
  problem.known = 2;  // the first two of both belong together, right or wrong
  for (const TipAssignment& assignment : MatchTips(problem, 10)) {
    EXPECT_EQ(assignment.target_of[0], 0);
    EXPECT_EQ(assignment.target_of[1], 1);
  }
}

TEST(MatchTips, LeavesOutATipThatTheOtherDoesNotHave) {
  TipProblem problem;
  const Eigen::Vector4d source(0, 1, 2.5, 9), target(0, 1, 2.5, -40);
  problem.source_distances =
      (source.replicate(1, 4) - source.transpose().replicate(4, 1)).cwiseAbs();
  problem.target_distances =
      (target.replicate(1, 4) - target.transpose().replicate(4, 1)).cwiseAbs();
  problem.unlike = Eigen::MatrixXd::Zero(4, 4);
  EXPECT_EQ(MatchTips(problem, 1)[0].target_of, (std::vector<int>{0, 1, 2, -1}));
}

}  // namespace keypose::registration::tip_matching_test
