#include "synth/scores/pick.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "synth/scores/testing/creature.h"
#include "synth/worlds/world.h"

namespace keypose::synth::pick_test {

using Eigen::Vector3d;

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

}  // namespace keypose::synth::pick_test
