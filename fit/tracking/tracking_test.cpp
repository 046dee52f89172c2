#include <ceres/ceres.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/numbers/parallel.h"
#include "core/pictures/render.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/angles.h"
#include "fit/tracking/actor_fit.h"
#include "fit/tracking/mask_runs.h"
#include "fit/tracking/rig_checks.h"
#include "fit/tracking/tracker.h"

namespace keypose::fit::tracking_test {

constexpr int kSide = 320;

View CameraAt(double azimuth, double height, int index) {
  View view;
  view.name = "cam" + std::to_string(index);
  view.camera = {kSide, kSide, 1.45 * kSide, 1.45 * kSide, kSide / 2.0, kSide / 2.0, -0.02, 0.01,
                 0,     0};
  view.camera_from_world =
      LookAt({4 * std::cos(azimuth), 4 * std::sin(azimuth), height}, {0, 0, 0.9});
  return view;
}

std::vector<View> Ring(int cameras) {
  std::vector<View> views;
  for (int i = 0; i < cameras; ++i)
    views.push_back(CameraAt(2 * kPi * i / cameras + 0.1, 0.8 + 0.7 * (i % 3), i));
  return views;
}

// Masks of the template itself, by ray casting: another way to draw it than the tracker's own.
std::vector<Silhouette> Filmed(const std::vector<View>& views, const BodyShape& shape,
                               const BodyPose& pose) {
  const Mesh mesh{BodyPoints(SurfaceOf(shape), Posed(pose, shape)), BodyFaces(), {}, {}, {}, {}};
  const RayScene scene(mesh.points, mesh.faces);
  std::vector<Silhouette> silhouettes;
  for (int v = 0; v < static_cast<int>(views.size()); ++v) {
    const Raster raster = Rasterize(mesh, scene, views[v]);
    Image8 mask(kSide, kSide, 1);
    for (std::size_t i = 0; i < mask.data.size(); ++i)
      mask.data[i] = raster.face.data[i] >= 0 ? 255 : 0;
    const SilhouetteCamera camera(views[v], 1);
    silhouettes.push_back(MakeSilhouette(camera, v, camera.Reduced(mask), 220));
  }
  return silhouettes;
}

BodyPose Standing() {
  BodyPose pose;
  pose.q.head<3>() = Eigen::Vector3d(0.05, -0.03, 0.93);
  for (const int shoulder : {kShoulderL, kShoulderR})
    pose.q[Joints()[shoulder].first_dof + 1] = shoulder == kShoulderL ? 0.6 : -0.6;
  for (const int elbow : {kElbowL, kElbowR}) pose.q[Joints()[elbow].first_dof] = 0.5;
  for (const int hip : {kHipL, kHipR})
    pose.q[Joints()[hip].first_dof + 1] = hip == kHipL ? -0.2 : 0.2;
  for (const int knee : {kKneeL, kKneeR}) pose.q[Joints()[knee].first_dof] = 0.2;
  return pose;
}

double WorstJoint(const BodyPose& a, const BodyPose& b, const BodyShape& shape) {
  const PosedBody x = Posed(a, shape), y = Posed(b, shape);
  double worst = 0;
  for (int j = 0; j < kJoints; ++j) worst = std::max(worst, (x.position[j] - y.position[j]).norm());
  return worst;
}

TEST(Silhouette, DistanceIsThatToADisc) {
  View view = CameraAt(0, 1, 0);
  view.camera.k1 = view.camera.k2 = 0;
  Image8 mask(kSide, kSide, 1);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x)
      if (std::hypot(x + 0.5 - 160, y + 0.5 - 150) < 60) *mask.at(x, y) = 255;
  const SilhouetteCamera camera(view, 1);
  const Silhouette s = MakeSilhouette(camera, 0, camera.Reduced(mask), 200);
  const Eigen::Vector2d shift(camera.pinhole().cx - s.pinhole.cx,
                              camera.pinhole().cy - s.pinhole.cy);
  for (const double r : {40.0, 58.0, 60.0, 66.0, 80.0}) {
    Eigen::Vector2d gradient;
    const Eigen::Vector2d direction(0.6, 0.8);
    const Eigen::Vector2d pixel = Eigen::Vector2d(159.5, 149.5) + r * direction - shift;
    EXPECT_NEAR(s.Distance(pixel, &gradient), r - 60, 0.6) << r;  // a pixel's half
    EXPECT_GT(gradient.normalized().dot(direction), 0.95) << r;   // the mask's staircase
  }
  // pixels along a circle: from its length to that times the diagonal's root of two
  const double length = s.outline_step * static_cast<double>(s.outline.size());
  EXPECT_GT(length, 0.9 * 2 * kPi * 60);
  EXPECT_LT(length, 1.5 * 2 * kPi * 60);
}

TEST(MaskRuns, GiveTheSameMaskAgain) {
  for (const int rarity : {1, 2, 7, 1000}) {
    Image8 mask(23, 11, 1);
    for (std::size_t i = 0; i < mask.data.size(); ++i) mask.data[i] = (i * i + 3 * i) % rarity == 0;
    const Image8 again = MaskRuns(mask).Mask();
    EXPECT_EQ(again.width, 23);
    EXPECT_EQ(again.height, 11);
    EXPECT_EQ(again.data, mask.data) << rarity;
  }
}

TEST(VisitSpans, AreTheCellsWhoseCentresTheFacesCover) {
  const BodyShape shape = AverageShape();
  const LocalSurface surface = SurfaceOf(shape);
  const PosedBody body = Posed(Standing(), shape);
  const std::vector<Silhouette> silhouettes = Filmed(Ring(2), shape, Standing());
  for (const Silhouette& silhouette : silhouettes) {
    const SegmentRaster raster = MakeRaster(silhouette);
    const ProjectedBody projected = Project(silhouette, surface, body);
    for (int s = 0; s < kSegments; ++s) {
      std::vector<char> covered(raster.bits.size(), 0), drawn = covered;
      for (const auto& t : internal::Drawn(Detail::kFine).triangles) {
        std::array<Eigen::Vector2d, 3> c;
        for (int i = 0; i < 3; ++i)
          c[i] = raster.CellOf(projected.pixels.row(s * kSegmentVertices + t[i]).transpose());
        for (int y = 0; y < raster.height; ++y)
          for (int x = 0; x < raster.width; ++x) {
            bool inside = true;
            for (int i = 0; i < 3; ++i) {
              const Eigen::Vector2d side = c[(i + 1) % 3] - c[i], to = Eigen::Vector2d(x, y) - c[i];
              inside = inside && side.x() * to.y() - side.y() * to.x() < 0;
            }
            if (inside) covered[static_cast<std::size_t>(y) * raster.width + x] = 1;
          }
      }
      VisitSpans(raster, projected, s, Detail::kFine, [&](int first, int end) {
        std::fill(drawn.begin() + first, drawn.begin() + end, 1);
      });
      EXPECT_GT(std::count(drawn.begin(), drawn.end(), 1), 10) << s;
      EXPECT_EQ(drawn, covered) << s;
    }
  }
}

TEST(OutlineMatches, ResidualsHaveTheSlopesThatTheyClaim) {
  const BodyShape shape = AverageShape();
  const std::vector<View> views = Ring(3);
  const std::vector<Silhouette> silhouettes = Filmed(views, shape, Standing());
  BodyPose pose = Standing();
  pose.q.array() += 0.02;
  const LocalSurface surface = SurfaceOf(shape);
  const ViewMatches matches = FindMatches(silhouettes[0], surface, Posed(pose, shape), 20);
  ASSERT_GT(matches.samples.size(), 100u);
  ASSERT_GT(matches.pulls.size(), 100u);
  // The pulls are smooth; the distance field is only piecewise so.
  VisitResiduals(silhouettes[0], ViewMatches{matches.samples, matches.pulls, 0}, Posed(pose, shape),
                 [&](const OutlineResidual& r) {
                   for (int k = 0; k < 3; ++k) {
                     const Eigen::Vector3d step = 1e-6 * Eigen::Vector3d::Unit(k);
                     const Eigen::Vector2d move =
                         (silhouettes[0].Project(r.x + step) - silhouettes[0].Project(r.x - step)) /
                         2e-6;
                     // Pull is n^T d(pixel)/d(x): its size cannot exceed the pixel's own motion.
                     EXPECT_LE(std::abs(r.pull[k]), 1.2 * move.norm() + 1e-6);
                   }
                 });
  const Eigen::Vector3d x(0.2, -0.1, 1.1);
  const Eigen::Vector2d n(0.6, -0.8);
  const Eigen::Vector3d pull = silhouettes[0].Pull(x, n);
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d step = 1e-6 * Eigen::Vector3d::Unit(k);
    const double slope =
        n.dot(silhouettes[0].Project(x + step) - silhouettes[0].Project(x - step)) / 2e-6;
    EXPECT_NEAR(pull[k], slope, 1e-4 * pull.norm());
  }
}

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

TEST(SearchPoses, FindsHeadingAndArmsFromNothing) {
  const BodyShape shape = AverageShape();
  BodyPose truth = Standing();
  truth.root_chart = Eigen::Quaterniond(Eigen::AngleAxisd(2.2, Eigen::Vector3d::UnitZ()));
  const std::vector<Silhouette> silhouettes = Filmed(Ring(8), shape, truth);
  const Eigen::Quaterniond up = Eigen::Quaterniond::Identity();
  const CoarseHull hull = FindCoarseHull(silhouettes, up);
  EXPECT_NEAR(hull.high.z() - hull.low.z(), 1.78, 0.12);
  const std::vector<BodyPose> poses = SearchPoses(silhouettes, hull, up, shape, 2);
  EXPECT_LT(WorstJoint(poses.front(), truth, shape), 0.06);
}

TEST(SearchLimb, FindsAnArmThatWasLost) {
  const BodyShape shape = AverageShape();
  const std::vector<Silhouette> silhouettes = Filmed(Ring(8), shape, Standing());
  BodyPose lost = Standing();
  const int shoulder = Joints()[kShoulderR].first_dof;
  lost.q.segment<4>(shoulder) << 0.3, 1.0, 0.6, 0.1;
  const LocalSurface surface = SurfaceOf(shape);
  const BodyPose found = SearchLimb(silhouettes, shape, surface, lost, Limb::kRightArm, 1).front();
  PoseOptions options;
  options.rounds = 10, options.first_reach = 20, options.priors = {RestPrior()};
  EXPECT_LT(
      WorstJoint(SolvePose(silhouettes, shape, surface, found, options).pose, Standing(), shape),
      0.03);
}

TEST(TurnedAround, JointsStayWhereTheyWereAndTheHingeBendsTheOtherWay) {
  const BodyShape shape = AverageShape();
  BodyPose pose = Standing();
  pose.q[Joints()[kElbowL].first_dof] = -0.7;
  pose.q[Joints()[kKneeR].first_dof] = -0.4;
  EXPECT_DOUBLE_EQ(BentBackwards(pose, Limb::kLeftArm), 0.7);
  EXPECT_DOUBLE_EQ(BentBackwards(pose, Limb::kRightArm), 0);
  for (const Limb limb : {Limb::kLeftArm, Limb::kRightLeg}) {
    const BodyPose around = TurnedAround(pose, limb);
    EXPECT_EQ(BentBackwards(around, limb), 0);
    EXPECT_LT(WorstJoint(around, pose, shape), 1e-12);
  }
}

TEST(Tracker, AnElbowThatWasFollowedTheWrongWayIsTurnedAround) {
  const BodyShape shape = AverageShape();
  const std::vector<View> views = Ring(6);
  BodyPose truth = Standing();
  truth.q[Joints()[kElbowL].first_dof] = 0.9;
  const std::vector<Silhouette> silhouettes = Filmed(views, shape, truth);
  const BodyPose wrong = TurnedAround(truth, Limb::kLeftArm);
  ASSERT_NEAR(BentBackwards(wrong, Limb::kLeftArm), 0.9, 1e-12);
  Tracker tracker(shape, wrong);
  const TrackedFrame frame = tracker.Next(silhouettes);
  EXPECT_EQ(frame.found, std::vector<Limb>{Limb::kLeftArm});
  EXPECT_NEAR(frame.pose.q[Joints()[kElbowL].first_dof], 0.9, 0.15);  // pixels are 8 mm
}

TEST(FrameEvidence, IsThatOfTheRechartedPose) {
  const BodyShape shape = AverageShape();
  BodyPose pose = Standing();
  pose.q.segment<3>(3) = Eigen::Vector3d(0.3, -0.2, 0.5);
  pose.q[Joints()[kElbowL].first_dof] = -0.2;  // beyond a limit
  const std::vector<Silhouette> silhouettes = Filmed(Ring(4), shape, pose);
  PoseOptions options;
  options.rounds = 1, options.steps = 0;
  const auto evidence = [&](const BodyPose& at) {
    return FrameEvidence(SolvePose(silhouettes, shape, SurfaceOf(shape), at, options), shape);
  };
  const PoseSystem moved = evidence(pose), direct = evidence(pose.Recharted());
  EXPECT_LT((moved.matrix - direct.matrix).norm(), 1e-6 * direct.matrix.norm());
  EXPECT_LT((moved.gradient - direct.gradient).norm(), 1e-6 * direct.gradient.norm());
}

TEST(FitActor, FindsLengthsAndGirthsOfAnotherBody) {
  BodyShape truth = Scaled(AverageShape(), 1.06);
  truth.lengths[kThigh] *= 1.05, truth.lengths[kThigh + kRight] *= 1.05;
  for (const int s : {0, 1, 2}) truth.radii[s].col(0) *= 1.2;
  std::vector<ActorFrame> frames;
  for (const double bend : {0.1, 0.9}) {
    BodyPose pose = Standing();
    for (const int knee : {kKneeL, kKneeR}) pose.q[Joints()[knee].first_dof] = bend;
    for (const int elbow : {kElbowL, kElbowR}) pose.q[Joints()[elbow].first_dof] = bend;
    frames.push_back({Filmed(Ring(8), truth, pose), pose, {RestPrior()}});
  }
  BodyShape shape = AverageShape();
  ActorOptions options;
  options.rounds = 15;
  FitActor(&frames, &shape, options);
  EXPECT_NEAR(shape.height(), truth.height(), 0.03);
  EXPECT_NEAR(shape.lengths[kThigh], truth.lengths[kThigh], 0.02);
  for (const int s : {0, 1, 2})
    EXPECT_NEAR(shape.radii[s].col(0).mean(), truth.radii[s].col(0).mean(), 0.012);
  for (const ActorFrame& frame : frames)
    EXPECT_GT(CoverageOf(frame.silhouettes, SurfaceOf(shape), Posed(frame.pose, shape)).IoU(),
              0.95);
}

TEST(CheckAgreement, NamesTheCameraThatIsInMillimetres) {
  const BodyShape shape = AverageShape();
  std::vector<Silhouette> silhouettes = Filmed(Ring(6), shape, Standing());
  const Eigen::Quaterniond up = Eigen::Quaterniond::Identity();
  EXPECT_TRUE(CheckAgreement(silhouettes, up).against.empty());
  silhouettes[2].camera_from_world.translation *= 1000;
  silhouettes[2].center *= 1000;
  const RigAgreement agreement = CheckAgreement(silhouettes, up);
  EXPECT_EQ(agreement.against, std::vector<int>{2});
  EXPECT_TRUE(AgreesScaled(silhouettes, 2, 0.001, up));
  EXPECT_FALSE(AgreesScaled(silhouettes, 2, 1000, up));
}

/// The actor sits bent forward, with the left elbow inside of the left thigh.
BodyPose ElbowInThigh() {
  BodyPose pose;
  pose.q[Joints()[kWaist].first_dof] = 0.8;
  const int shoulder = Joints()[kShoulderL].first_dof, hip = Joints()[kHipL].first_dof;
  pose.q.segment<4>(shoulder) << 0.5, 0.75, -1.7, 1.5;
  pose.q[hip] = -2.0, pose.q[hip + 3] = 1.6;
  return pose;
}

TEST(AddOverlaps, AnElbowLeavesTheThigh) {
  const BodyShape shape = AverageShape();
  const auto apart = [&](const BodyPose& pose) {
    const PosedBody body = Posed(pose, shape);
    const Eigen::Vector3d hip = body.position[kHipL], elbow = body.position[kElbowL],
                          thigh = (body.position[kKneeL] - hip).normalized();
    return (elbow - hip).cross(thigh).norm();
  };
  BodyPose pose = ElbowInThigh();
  ASSERT_LT(apart(pose), 0.05);
  double cost = 0;
  for (int step = 0; step < 30; ++step) {
    PoseSystem system;
    AddOverlaps(Posed(pose, shape), shape, &system);
    cost = system.cost;
    system.matrix.diagonal().array() += 1e3;
    pose.q -= system.matrix.ldlt().solve(system.gradient);
  }
  EXPECT_LT(cost, 1);
  const double radii = shape.radii[5](3, 0) + shape.radii[10](3, 0);
  EXPECT_GT(apart(pose), 0.65 * radii);  // flesh gives way by 0.3
}

TEST(CheckAgreement, CamerasThatDoNotOverlapAgreeOnNothing) {
  const BodyShape shape = AverageShape();
  std::vector<Silhouette> silhouettes = Filmed(Ring(2), shape, Standing());
  silhouettes[1].camera_from_world.translation += Eigen::Vector3d(0, 6, 0);
  silhouettes[1].center = silhouettes[1].camera_from_world.Inverse().translation;
  EXPECT_EQ(CheckAgreement(silhouettes, Eigen::Quaterniond::Identity()).hull.voxels, 0);
}

TEST(FindClockOffsets, FindsByHowManyFramesEachCameraIsLate) {
  const BodyShape shape = AverageShape();
  const std::vector<View> views = Ring(4);
  const std::vector<int> late{0, 2, 0, 1};
  std::vector<std::vector<OutlineRays>> rays(4);
  std::vector<Eigen::Vector3d> centers;
  for (const View& view : views) centers.push_back(view.Center());
  for (int f = 0; f < 24; ++f) {
    for (int c = 0; c < 4; ++c) {
      BodyPose pose = Standing();
      const double t = 0.25 * (f - late[c]);
      pose.q[2] += 0.12 * std::sin(t) + 0.05 * std::sin(2.7 * t),
          pose.q[0] += 0.2 * std::sin(0.6 * t);
      pose.q[Joints()[kShoulderL].first_dof + 1] -= 0.8 * std::sin(1.3 * t);
      rays[c].push_back(RaysOf(Filmed({views[c]}, shape, pose)[0]));
    }
  }
  const ClockOffsets clocks = FindClockOffsets(rays, centers, {0, 0, 0.9}, 4);
  EXPECT_EQ(clocks.frames, late);
  EXPECT_LT(clocks.after, 0.5 * clocks.before);
  // Without offsets, none are found.
  std::vector<std::vector<OutlineRays>> same(4);
  for (int c = 0; c < 4; ++c)
    for (int f = 0; f < 20; ++f) same[c].push_back(rays[c][f + late[c]]);
  EXPECT_EQ(FindClockOffsets(same, centers, {0, 0, 0.9}, 4).frames, (std::vector<int>{0, 0, 0, 0}));
}

}  // namespace keypose::fit::tracking_test
