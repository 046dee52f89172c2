#include "synth/scores/score.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "synth/photographs/photographer.h"
#include "synth/scores/testing/creature.h"
#include "synth/worlds/world.h"

namespace keypose::synth::score_test {

using Eigen::Vector3d;

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

}  // namespace keypose::synth::score_test
