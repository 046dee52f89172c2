// A place by outlines, and how well outlines show the lens.
#include <gtest/gtest.h>

#include "composite/locating/refinement/refine_placement.h"
#include "composite/locating/testing/odd_body.h"
#include "core/pictures/mask_overlap.h"

namespace keypose::composite::refine_test {

TEST(Refined, OutlinesBringADisturbedPlaceBack) {
  const Mesh body = OddBody();
  const Figure figure(body.points, body.faces);
  const Placement truth = LookingFrom(-40, 20);
  const Image8 matte = Covered(figure, truth);
  const PictureEvidence evidence = MakeEvidence(GreyPicture(matte), matte, 0.5, 1);
  const Placement found =
      Refined(figure, evidence, Disturbed(truth, 5, 0.004), {40, 3, 15, nullptr, false}, {});
  EXPECT_LT(ShiftBetween(found, truth, body.points), 0.5);
  EXPECT_GT(MaskIoU(Covered(figure, found), matte), 0.99);
}

TEST(CenterDeviation, FallsWithTheRootOfTheFramesAndIsGreatForAFarFigure) {
  const Mesh body = OddBody();
  const Figure figure(body.points, body.faces);
  const auto deviation_at = [&](double distance, int frames) {
    Placement truth = LookingFrom(-40, 20, distance);
    truth.camera.fx = truth.camera.fy = 900 * distance / 0.55;
    const Image8 matte = Covered(figure, truth);
    const PictureEvidence evidence = MakeEvidence(GreyPicture(matte), matte, 0.5, 1);
    const LensPrior known;  // focal length and distortion are given
    return CenterDeviation(std::vector<SharedFrame>(frames, {&figure, &evidence, truth}), {3, 3, 1},
                           known);
  };
  const double one = deviation_at(0.55, 1);
  EXPECT_GT(one, 0.5);
  EXPECT_NEAR(deviation_at(0.55, 4), one / 2, 0.02 * one);
  EXPECT_GT(deviation_at(2.2, 1), 3 * one) << "a long lens from far away hardly shows it";
}

TEST(ProfileFocal, NearIsKnownAndFarIsNot) {
  const Mesh body = OddBody();
  const Figure figure(body.points, body.faces);
  const auto deviation_at = [&](double distance) {
    Placement truth = LookingFrom(-40, 20, distance);
    truth.camera.fx = truth.camera.fy = 900 * distance / 0.55;
    const Image8 matte = Covered(figure, truth);
    const PictureEvidence evidence = MakeEvidence(GreyPicture(matte), matte, 0.5, 1);
    return ProfileFocal({{&figure, &evidence, truth}}, 6).deviation;
  };
  EXPECT_LT(deviation_at(0.4), 0.05);
  EXPECT_GT(deviation_at(20), 0.1);
}

}  // namespace keypose::composite::refine_test
