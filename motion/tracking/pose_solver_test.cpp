#include "motion/tracking/pose_solver.h"

#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/numbers/parallel.h"
#include "core/values/angles.h"
#include "motion/tracking/pose_search.h"
#include "motion/tracking/testing/filmed_body.h"

namespace keypose::motion::pose_solver_test {

/// The frozen pulls of all views as one residual vector, for Ceres' own derivatives and minimum.
struct FrozenPulls {
  const std::vector<Silhouette>* silhouettes;
  const std::vector<ViewMatches>* matches;
  BodyPose chart;
  BodyShape shape;

  bool operator()(double const* const* q, double* residuals) const {
    BodyPose pose = chart;
    pose.q = Eigen::Map<const DofVector>(q[0]);
    const PosedBody body = Posed(pose, shape);
    int row = 0;
    for (std::size_t v = 0; v < silhouettes->size(); ++v)
      for (const ViewMatches::Pull& pull : (*matches)[v].pulls) {
        const OutlineSample& sample = (*matches)[v].samples[pull.sample];
        const Eigen::Vector3d x = body.ToWorld(Segments()[sample.segment].joint, sample.local);
        residuals[row++] = pull.normal.dot((*silhouettes)[v].Project(x) - pull.target);
      }
    for (int i = 0; i < kDofs; ++i) residuals[row++] = 0.5 * (q[0][i] - chart.q[i]);
    return true;
  }
};

TEST(OutlineSystem, OwnGaussNewtonReachesTheMinimumThatCeresFinds) {
  const BodyShape shape = AverageShape();
  const std::vector<Silhouette> silhouettes = Filmed(Ring(6), shape, Standing());
  BodyPose start = Standing();
  for (int i = 0; i < kDofs; ++i) start.q[i] += (i < 3 ? 0.01 : 0.04) * std::sin(3.0 * i);
  const PosedBody body = Posed(start, shape);
  std::vector<ViewMatches> matches = FindAllMatches(silhouettes, SurfaceOf(shape), body, 20);
  int rows = kDofs;
  for (const ViewMatches& view : matches) rows += static_cast<int>(view.pulls.size());

  auto* cost = new ceres::DynamicNumericDiffCostFunction<FrozenPulls>(
      new FrozenPulls{&silhouettes, &matches, start, shape});
  cost->AddParameterBlock(kDofs), cost->SetNumResiduals(rows);
  DofVector by_ceres = start.q;
  ceres::Problem problem;
  problem.AddResidualBlock(cost, nullptr, by_ceres.data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR, options.max_num_iterations = 50,
  options.function_tolerance = 1e-14;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);

  // Our own: the same rows with our analytic derivatives.
  BodyPose own = start;
  for (int iteration = 0; iteration < 20; ++iteration) {
    const PosedBody at = Posed(own, shape);
    PoseSystem system;
    for (std::size_t v = 0; v < silhouettes.size(); ++v)
      for (const ViewMatches::Pull& pull : matches[v].pulls) {
        const OutlineSample& sample = matches[v].samples[pull.sample];
        const int joint = Segments()[sample.segment].joint;
        const Eigen::Vector3d x = at.ToWorld(joint, sample.local);
        DofVector row = DofVector::Zero();
        at.AddPoseRow(joint, x, silhouettes[v].Pull(x, pull.normal), row.data());
        system.matrix += row * row.transpose();
        system.gradient += pull.normal.dot(silhouettes[v].Project(x) - pull.target) * row;
      }
    QuadraticPrior prior;
    prior.mean = start.q, prior.weight.setConstant(0.25);
    AddQuadratic(prior, own.q, &system);
    own.q -= system.matrix.ldlt().solve(system.gradient);
  }
  EXPECT_LT((own.q - by_ceres).cwiseAbs().maxCoeff(), 1e-5) << summary.BriefReport();
}

TEST(SolvePose, FindsThePoseThatWasFilmed) {
  const BodyShape shape = AverageShape();
  const std::vector<Silhouette> silhouettes = Filmed(Ring(8), shape, Standing());
  BodyPose start = Standing();
  for (int i = 0; i < kDofs; ++i) start.q[i] += (i < 3 ? 0.04 : 0.15) * std::sin(5.0 * i + 1);
  PoseOptions options;
  options.rounds = 15, options.first_reach = 20, options.priors = {RestPrior()};
  const PoseFit fit = SolvePose(silhouettes, shape, SurfaceOf(shape), start, options);
  // A pixel is 9 mm here, and an outline of a few hundred of them is known to a tenth.
  EXPECT_LT(WorstJoint(fit.pose, Standing(), shape), 0.02);
  EXPECT_GT(CoverageOf(silhouettes, SurfaceOf(shape), Posed(fit.pose, shape)).IoU(), 0.95);
}

TEST(SolvePose, SameBitsForAnyThreadCount) {
  const BodyShape shape = AverageShape();
  const std::vector<Silhouette> silhouettes = Filmed(Ring(4), shape, Standing());
  BodyPose start = Standing();
  start.q.array() += 0.03;
  SetThreadCount(1);
  const PoseFit one = SolvePose(silhouettes, shape, SurfaceOf(shape), start, {});
  SetThreadCount(3);
  const PoseFit three = SolvePose(silhouettes, shape, SurfaceOf(shape), start, {});
  SetThreadCount(0);
  EXPECT_EQ(one.pose.q, three.pose.q);
}

TEST(StandardDeviations, AStraightLimbsTwistIsNotSeenAndABentOnesIs) {
  BodyShape shape = AverageShape();
  // Round arms and hands: nothing but the forearm's direction tells the twist.
  for (const int s : {4, 5, 6, 7, 8, 9}) shape.radii[s].rightCols<kHarmonics - 1>().setZero();
  const int twist = Joints()[kShoulderL].first_dof, elbow = Joints()[kElbowL].first_dof;
  DofVector deviation[2];
  for (const bool bent : {false, true}) {
    BodyPose pose = Standing();
    pose.q[elbow] = bent ? 1.2 : 0.0;
    const std::vector<Silhouette> silhouettes = Filmed(Ring(8), shape, pose);
    PoseOptions options;
    options.rounds = 1, options.steps = 0;
    deviation[bent] =
        StandardDeviations(SolvePose(silhouettes, shape, SurfaceOf(shape), pose, options));
  }
  EXPECT_GT(deviation[0][twist], 5 * deviation[1][twist]);
  EXPECT_LT(deviation[1][twist], 10 * kDegree);
}

}  // namespace keypose::motion::pose_solver_test
