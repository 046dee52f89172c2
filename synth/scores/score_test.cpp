#include "synth/scores/score.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <iterator>

#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "synth/photographs/photographer.h"
#include "synth/scores/pick.h"
#include "synth/worlds/polygonize.h"
#include "synth/worlds/world.h"

namespace keypose::synth::score_test {

using Eigen::Vector3d;

const World& Creature() {
  static const World world = [] {
    WorldOptions options;
    options.spacing_m = 0.006;
    return MakeWorld(options);
  }();
  return world;
}

Similarity3 SomeSimilarity() {
  return {3.7,
          Eigen::AngleAxisd(1.1, Vector3d(0.3, -0.5, 0.8).normalized()).toRotationMatrix(),
          {0.4, -2, 1.5}};
}

Scene RingScene() {
  PhotographerOptions options;
  options.views = 10;
  options.width = 64, options.height = 48;
  const Photographer photographer(Creature(), Creature().PoseNamed("rest"), options);
  Scene scene;
  for (int i = 0; i < photographer.view_count(); ++i) scene.views.push_back(photographer.ViewAt(i));
  return scene;
}

// The scene as from another program, in a different frame.
Scene Moved(const Scene& scene, const Similarity3& new_from_old) {
  Scene moved = scene;
  for (View& view : moved.views) {
    const Vector3d center = new_from_old * view.Center();
    view.camera_from_world.rotation =
        view.camera_from_world.rotation * Eigen::Quaterniond(new_from_old.rotation).conjugate();
    view.camera_from_world.translation = -(view.camera_from_world.rotation * center);
  }
  return moved;
}

Mesh BallOf(double radius) {
  return Polygonize([&](const Vector3d& x) { return x.norm() - radius; },
                    Vector3d::Constant(-1.2 * radius), Vector3d::Constant(1.2 * radius),
                    radius / 12);
}

TEST(ScoreCameras, FindsTheFrameThatTheModelIsIn) {
  const Scene truth = RingScene();
  const CameraScore score = ScoreCameras(truth, Moved(truth, SomeSimilarity()), {0, 0, 0.1});
  EXPECT_EQ(score.placed, 10);
  EXPECT_LT(score.max_over_distance, 1e-12);
  EXPECT_NEAR(score.truth_from_model.scale, 1 / 3.7, 1e-12);
}

TEST(ScoreCameras, MeasuresAMisplacedCamera) {
  const Scene truth = RingScene();
  Scene model = truth;
  View& view = model.views[4];
  view.camera_from_world.translation += view.camera_from_world.rotation * Vector3d(0, 0, 0.010);
  const CameraScore score = ScoreCameras(truth, model, {0, 0, 0.1});
  EXPECT_NEAR(score.max_m, 0.010,
              0.004);  // the fit distributes about a tenth of the error over the others
  EXPECT_LT(score.mean_m, 0.004);
}

TEST(ScoreCameras, MissingCamerasAreCountedAndTooFewThrow) {
  const Scene truth = RingScene();
  Scene model = truth;
  model.views.resize(7);
  EXPECT_EQ(ScoreCameras(truth, model, {0, 0, 0.1}).placed, 7);
  EXPECT_EQ(ScoreCameras(truth, model, {0, 0, 0.1}).total, 10);
  model.views.resize(2);
  EXPECT_THROW(ScoreCameras(truth, model, {0, 0, 0.1}), InputError);
}

TEST(ScoreSurface, ConcentricBallsAreTheDifferenceOfTheirRadiiApart) {
  Mesh inner = BallOf(1), outer = inner;
  outer.points *= 1.03;
  const SurfaceScore score = ScoreSurface(outer, inner);
  const double diagonal = BoundingDiagonal(outer.points);
  EXPECT_NEAR(score.mean_to_truth, 0.03 / diagonal,
              0.0002);  // faces are chords, slightly inside both balls
  EXPECT_NEAR(score.mean_from_truth, 0.03 / diagonal, 0.0002);
  EXPECT_NEAR(score.max_from_truth, 0.03 / diagonal, 0.0002);
}

TEST(ScoreSurface, AMissingPartShowsFromTheTruthOnly) {
  const Mesh ball = BallOf(1);
  Mesh half = ball;
  Eigen::Index kept = 0;
  for (Eigen::Index f = 0; f < ball.faces.rows(); ++f)
    if (ball.points(ball.faces(f, 0), 2) < 0) half.faces.row(kept++) = ball.faces.row(f);
  half.faces.conservativeResize(kept, 3);
  const SurfaceScore score = ScoreSurface(ball, half);
  EXPECT_LT(score.max_to_truth, 1e-12);
  EXPECT_GT(score.max_from_truth, 0.3);
}

TEST(RefineAlignment, UndoesASmallError) {
  const Mesh& truth = Creature().rest;
  const Similarity3 error{
      1.01, Eigen::AngleAxisd(0.02, Vector3d::UnitY()).toRotationMatrix(), {0.001, -0.002, 0.001}};
  Mesh mesh = truth;
  mesh.points = Transformed(error, truth.points);
  const Similarity3 refined = RefineAlignment(truth, mesh, Similarity3{}, 60);
  EXPECT_LT((Transformed(refined, mesh.points) - truth.points).rowwise().norm().mean(), 0.0002);
}

TEST(ScoreCorrespondence, IsZeroForTheTruthAndTheShiftForAShift) {
  const Mesh rest = TruthSurface(Creature(), Creature().PoseNamed("rest")),
             bent = TruthSurface(Creature(), Creature().PoseNamed("bent"));
  EXPECT_LT(ScoreCorrespondence(rest, bent, rest, bent.points).max, 1e-12);
  PointsX3 shifted = bent.points;
  shifted.col(1).array() += 0.004;
  const CorrespondenceScore score = ScoreCorrespondence(rest, bent, rest, shifted);
  EXPECT_NEAR(score.mean, 0.004 / BoundingDiagonal(bent.points), 1e-12);
  EXPECT_NEAR(score.max, score.mean, 1e-12);
}

TEST(ScoreCorrespondence, SlidingAlongTheSurfaceIsAnError) {
  // A vertex lies exactly on the surface, but at another material point. Surface distance does not
  // notice this; correspondence must.
  const Mesh rest = TruthSurface(Creature(), Creature().PoseNamed("rest"));
  PointsX3 slid = rest.points;
  for (Eigen::Index f = 0; f < rest.faces.rows(); ++f)
    slid.row(rest.faces(f, 0)) = rest.points.row(rest.faces(f, 1));
  EXPECT_GT(ScoreCorrespondence(rest, rest, rest, slid).mean, 0.001);
}

TEST(ScoreCorrespondence, OtherMeshesThrowInputError) {
  const Mesh rest = TruthSurface(Creature(), Creature().PoseNamed("rest"));
  EXPECT_THROW(ScoreCorrespondence(rest, BallOf(1), rest, rest.points), InputError);
  EXPECT_THROW(ScoreCorrespondence(rest, rest, rest, rest.points.topRows(10)), InputError);
}

TEST(PickLandmarks, ClicksLandOnTheTrueMaterialPointsOfTheModel) {
  const Pose& bent = Creature().PoseNamed("bent");
  const Mesh truth = TruthSurface(Creature(), bent);
  const Similarity3 model_from_truth = SomeSimilarity();
  Mesh model = truth;
  model.points = Transformed(model_from_truth, truth.points);
  const Picks picks = PickLandmarks(truth, Creature().landmarks, model, model_from_truth.Inverse());
  EXPECT_TRUE(picks.out_of_reach.empty());
  const PointsX3 places = LandmarkPositions(Creature(), bent);
  ASSERT_EQ(std::ssize(picks.landmarks), places.rows());
  for (std::size_t i = 0; i < picks.landmarks.size(); ++i) {
    const Vector3d expected = model_from_truth * Vector3d(places.row(i));
    EXPECT_LT((PositionOf(picks.landmarks[i], model) - expected).norm(), 1e-9)
        << picks.landmarks[i].name;
  }
}

TEST(PickLandmarks, PartsThatTheMeshLacksAreNamed) {
  const Mesh truth = TruthSurface(Creature(), Creature().PoseNamed("rest"));
  Mesh model = truth;
  Eigen::Index kept = 0;
  for (Eigen::Index f = 0; f < truth.faces.rows(); ++f)
    if (truth.points(truth.faces(f, 0), 2) < 0.15) model.faces.row(kept++) = truth.faces.row(f);
  model.faces.conservativeResize(kept, 3);
  const Picks picks = PickLandmarks(truth, Creature().landmarks, model, {});
  EXPECT_EQ(std::count(picks.out_of_reach.begin(), picks.out_of_reach.end(), "horn_tip"), 1);
  EXPECT_EQ(std::count(picks.out_of_reach.begin(), picks.out_of_reach.end(), "left_toe"), 0);
}

}  // namespace keypose::synth::score_test
