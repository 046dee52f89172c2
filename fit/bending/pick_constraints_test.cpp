// Picks as pulls, and which of them are refused.
#include <gtest/gtest.h>

#include <Eigen/LU>

#include "core/pictures/render.h"
#include "core/surfaces/shapes.h"
#include "fit/bending/pick_constraints.h"

namespace keypose::fit::marks_test {

const Pinhole kLens{800, 800, 1000, 1000, 400, 400};
constexpr int kFace = 17;

/// A ball of which a point is picked where it is after a shift.
class MarksOfABall : public ::testing::Test {
 protected:
  MarksOfABall() : ball_(MakeIcosphere(2)), cells_(ball_.points.rows()) {
    for (int v = 0; v < static_cast<int>(cells_.size()); ++v) cells_[v] = v / 9;
    point_ = {ball_.faces.row(kFace).transpose(), {0.2, 0.3, 0.5}};
    goal_ = PositionOf(point_, ball_.points) + Eigen::Vector3d(0.1, -0.2, 0.15);
    for (const Eigen::Vector3d& eye :
         {Eigen::Vector3d(6, 0, 1), Eigen::Vector3d(0, 6, 2), Eigen::Vector3d(-4, -4, 3)})
      views_.push_back({static_cast<int>(views_.size()), kLens, LookAt(eye, {0, 0, 0})});
  }
  PixelPick Pick(int view, const Eigen::Vector2d& beside = {0, 0}) const {
    const FitView& at = views_[view];
    return {"ear", point_, view, at.camera.Project(at.camera_from_world * goal_) + beside};
  }

  Mesh ball_;
  std::vector<int> cells_;
  SurfacePoint point_;
  Eigen::Vector3d goal_;
  std::vector<FitView> views_;
};

/// Where the pulls would have a shift of all vertices end.
Eigen::Vector3d ShiftOf(const std::vector<Constraint>& constraints, const PointsX3& points) {
  Eigen::Matrix3d q = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const Constraint& c : constraints) {
    q += c.q;
    b += c.q * (c.goal - c.arm - points.row(c.vertex).transpose());
  }
  return q.inverse() * b;
}

TEST_F(MarksOfABall, TwoPicksOfAPlaceMeetWhereItIs) {
  const PickConstraints marks({{Pick(0), Pick(1)}, {}}, ball_.points, cells_);
  std::vector<Constraint> pulls;
  for (const FitView& view : views_) marks.AddPixels(view, ball_.points, 3, 1e6, pulls);
  const Eigen::Vector3d shift = goal_ - PositionOf(point_, ball_.points);
  EXPECT_LT((ShiftOf(pulls, ball_.points) - shift).norm(), 1e-9);
  double weight = 0;
  for (const Constraint& pull : pulls) {
    EXPECT_EQ(cells_[pull.vertex], cells_[point_.vertices[2]]);
    weight += pull.q.trace();
  }
  EXPECT_NEAR(weight, 2 * 3 * 2, 1e-6);  // two rays, each across two directions
}

TEST_F(MarksOfABall, OnePickLeavesThePlaceFreeAlongItsRay) {
  const PickConstraints marks({{Pick(0)}, {}}, ball_.points, cells_);
  std::vector<Constraint> pulls;
  marks.AddPixels(views_[0], ball_.points, 1, 1e6, pulls);
  const Eigen::Vector3d ray = (goal_ - views_[0].Center()).normalized();
  for (const Constraint& pull : pulls) EXPECT_LT((pull.q * ray).norm(), 1e-12);
  pulls.clear();
  marks.AddPixels(views_[1], ball_.points, 1, 1e6, pulls);
  EXPECT_TRUE(pulls.empty());
}

TEST_F(MarksOfABall, APlaceInSpacePullsThereAndComesFromNoView) {
  const PickConstraints marks({{}, {{"ear", point_, goal_}}}, ball_.points, cells_);
  std::vector<Constraint> pulls;
  marks.AddPlaces(ball_.points, 1, 1e6, pulls);
  const Eigen::Vector3d shift = goal_ - PositionOf(point_, ball_.points);
  EXPECT_LT((ShiftOf(pulls, ball_.points) - shift).norm(), 1e-9);
  for (const Constraint& pull : pulls) EXPECT_EQ(pull.view, -1);
}

TEST_F(MarksOfABall, OfANameOnlyTheFarthestPickIsRefused) {
  PickConstraints marks({{Pick(0, {60, 0}), Pick(1, {0, 200}), Pick(2)}, {}}, ball_.points, cells_);
  const PointsX3 there =
      ball_.points.rowwise() + (goal_ - PositionOf(point_, ball_.points)).transpose();
  const auto refused = [&] {
    std::vector<bool> list;
    for (const PickQuality& mark : marks.Quality(views_, there)) list.push_back(mark.refused);
    return list;
  };
  EXPECT_NEAR(marks.Quality(views_, there)[1].off_px, 200, 1e-9);
  EXPECT_TRUE(marks.Refuse(views_, there, 0.1));
  EXPECT_EQ(refused(), (std::vector<bool>{false, true, false}));
  EXPECT_TRUE(marks.Refuse(views_, there, 0.1));
  EXPECT_EQ(refused(), (std::vector<bool>{true, true, false}));
  EXPECT_FALSE(marks.Refuse(views_, there, 0.1));
  std::vector<Constraint> pulls;
  for (int v = 0; v < 2; ++v) marks.AddPixels(views_[v], there, 1, 1, pulls);
  EXPECT_TRUE(pulls.empty());
}

}  // namespace keypose::fit::marks_test
