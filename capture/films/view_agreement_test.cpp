// Masks of a ball in cameras of known places.
#include "capture/films/view_agreement.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "capture/pictures/cv_image.h"

namespace keypose::capture::view_agreement_test {

using Eigen::Vector3d;

constexpr int kWidth = 240, kHeight = 200;
const Vector3d kBall(0.1, -0.1, 0.9);
constexpr double kRadius = 0.3;  // [m]

/// A camera four metres away at an angle about the vertical, which looks at the middle.
View ViewAt(double degrees) {
  View view;
  view.camera = {kWidth, kHeight, 260, 260, kWidth / 2.0, kHeight / 2.0};
  const double a = degrees * 3.14159265358979 / 180;
  const Vector3d centre(4 * std::cos(a), 4 * std::sin(a), 1.4), middle(0, 0, 0.9);
  const Vector3d forward = (middle - centre).normalized(),
                 right = forward.cross(Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d rotation;
  rotation << right.transpose(), forward.cross(right).transpose(), forward.transpose();
  view.camera_from_world.rotation = rotation;
  view.camera_from_world.translation = -(rotation * centre);
  return view;
}

Image8 MaskOf(const View& view, const Vector3d& ball) {
  Image8 mask(kWidth, kHeight, 1);
  const Eigen::Vector2d at = view.Project(ball);
  const double radius = 260 * kRadius / (view.camera_from_world * ball).z();
  cv::circle(MatOf(mask), {static_cast<int>(at.x()), static_cast<int>(at.y())},
             static_cast<int>(radius), cv::Scalar(255), -1);
  return mask;
}

class ViewAgreementOfABall : public ::testing::Test {
 protected:
  ViewAgreementOfABall() {
    for (const double degrees : {0, 80, 190, 280}) views_.push_back(ViewAt(degrees));
    for (const View& view : views_) masks_.push_back(MaskOf(view, kBall));
  }
  std::vector<View> views_;
  std::vector<Image8> masks_;
};

TEST_F(ViewAgreementOfABall, NobodyDeniesTheBallAndAllDenyTheCorner) {
  const ViewAgreement agreement(views_, masks_);
  ASSERT_TRUE(agreement.meets());
  const std::vector<Image8> denials = agreement.LeastDenials(masks_);
  for (std::size_t c = 0; c < views_.size(); ++c) {
    const Eigen::Vector2d at = views_[c].Project(kBall);
    EXPECT_EQ(*denials[c].at(static_cast<int>(at.x()), static_cast<int>(at.y())), 0) << c;
    EXPECT_EQ(*denials[c].at(2, 2), kMostDenials) << c;
  }
}

TEST_F(ViewAgreementOfABall, AThingThatOneCameraTakesForTheActorIsDeniedByTheOthers) {
  cv::rectangle(MatOf(masks_[1]), cv::Rect(100, 4, 40, 30), cv::Scalar(255), -1);
  const ViewAgreement agreement(views_, masks_);
  const std::vector<Image8> denials = agreement.LeastDenials(masks_);
  EXPECT_GE(*denials[1].at(120, 15), 2);
}

TEST_F(ViewAgreementOfABall, ACameraThatLostItIsToldByTheOthers) {
  const std::vector<Image8> unions = masks_;
  masks_[2] = Image8(kWidth, kHeight, 1);
  const ViewAgreement agreement(views_, unions);
  const std::vector<Image8> denials = agreement.LeastDenials(masks_);
  const Eigen::Vector2d at = views_[2].Project(kBall);
  EXPECT_EQ(*denials[2].at(static_cast<int>(at.x()), static_cast<int>(at.y())), 0);
  const Eigen::Vector2d there = views_[0].Project(kBall);
  EXPECT_EQ(*denials[0].at(static_cast<int>(there.x()), static_cast<int>(there.y())), 1)
      << "one camera that lost it does not convince the rest";
}

TEST_F(ViewAgreementOfABall, CamerasThatLookElsewhereDoNotMeet) {
  std::vector<View> wrong = views_;
  for (std::size_t c = 0; c < wrong.size(); ++c)
    wrong[c].camera_from_world.translation += Vector3d(c % 2 ? 30 : -30, c * 20.0, 0);
  EXPECT_FALSE(ViewAgreement(wrong, masks_).meets());
}

TEST(OddsOfDenials, AreTheRatiosOfTheMasksAndNeverRise) {
  Image8 mask(10, 10, 1), denials(10, 10, 1), area(10, 10, 1, 255);
  for (int i = 0; i < 100; ++i) {
    mask.data[i] = i < 40 ? 255 : 0;
    denials.data[i] = i < 36 ? 0 : i < 40 ? 2 : i < 46 ? 0 : 2;  // 36 of 40; 6 of 60
  }
  const std::vector<float> odds = OddsOfDenials({mask}, {denials}, area, 2.5);
  EXPECT_NEAR(odds[0], std::log((37.0 / 41) / (7.0 / 61)), 1e-5);
  EXPECT_NEAR(odds[2], std::log((5.0 / 41) / (55.0 / 61)), 1e-5);
  for (std::size_t d = 1; d < odds.size(); ++d) EXPECT_LE(odds[d], odds[d - 1]);
  EXPECT_GE(odds[1], -0.3F - 1e-6F);
}

}  // namespace keypose::capture::view_agreement_test
