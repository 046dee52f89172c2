// Errors, dropped repeats and warnings of CheckLandmarks.
#include "register/landmarks/landmarks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "core/surfaces/shapes.h"
#include "core/values/errors.h"

namespace keypose::registration::landmarks_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A box with faces small enough to measure distances along it.
Mesh FineTube() { return MakeCylinder(1, 6, 24, 30); }

/// The vertex nearest to a point, as a face and a corner.
PickedPair PickAt(const std::string& name, const Mesh& source, const Eigen::RowVector3d& on_source,
                  const Mesh& target, const Eigen::RowVector3d& on_target) {
  const auto nearest = [](const Mesh& mesh, const Eigen::RowVector3d& p, int& face,
                          Eigen::Vector3d& barycentric) {
    Eigen::Index vertex = 0;
    (mesh.points.rowwise() - p).rowwise().squaredNorm().minCoeff(&vertex);
    for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
      for (int k = 0; k < 3; ++k)
        if (mesh.faces(f, k) == vertex)
          face = static_cast<int>(f), barycentric = Eigen::Vector3d::Unit(k);
  };
  PickedPair pick;
  pick.name = name;
  nearest(source, on_source, pick.source_face, pick.source_barycentric);
  nearest(target, on_target, pick.target_face, pick.target_barycentric);
  return pick;
}

const std::vector<Eigen::RowVector3d> kPlaces = {
    {1, 0, 0.5}, {-1, 0, 1}, {0, 1, 2}, {0.2, -1, 3}, {1, 0.3, 4}, {-0.7, 0.7, 5.2}, {0, -1, 5.8}};

std::vector<PickedPair> Honest(const Mesh& source, const Mesh& target,
                               const Eigen::RowVector3d& stretch) {
  std::vector<PickedPair> picks;
  for (std::size_t k = 0; k < kPlaces.size(); ++k)
    picks.push_back(PickAt("p" + std::to_string(k), source, kPlaces[k], target,
                           kPlaces[k].cwiseProduct(stretch)));
  return picks;
}

TEST(CheckLandmarks, HonestPairsOfASquashedBodyRaiseNoDoubt) {
  const Mesh source = FineTube();
  Mesh target = source;
  const Eigen::RowVector3d squash(1.25, 1.2, 0.8);
  target.points.array().rowwise() *= squash.array();
  const CheckedLandmarks checked = CheckLandmarks(Honest(source, target, squash), source, target);
  EXPECT_EQ(checked.goals.size(), kPlaces.size());
  EXPECT_EQ(checked.duplicates, 0);
  EXPECT_FALSE(checked.coplanar);
  EXPECT_THAT(checked.warnings, IsEmpty());
}

TEST(CheckLandmarks, TwoExchangedTargetsAreBothNamed) {
  const Mesh tube = FineTube();
  std::vector<PickedPair> picks = Honest(tube, tube, {1, 1, 1});
  std::swap(picks[1].target_face, picks[5].target_face);
  std::swap(picks[1].target_barycentric, picks[5].target_barycentric);
  const std::vector<std::string> warnings = CheckLandmarks(picks, tube, tube).warnings;
  EXPECT_THAT(warnings, ElementsAre(::testing::AllOf(HasSubstr("'p1' and 'p5' look swapped"))));
}

TEST(CheckLandmarks, OneMisplacedLandmarkIsNamedWithWhatItContradicts) {
  const Mesh tube = FineTube();
  std::vector<PickedPair> picks = Honest(tube, tube, {1, 1, 1});
  const PickedPair wrong = PickAt("p0", tube, kPlaces[0], tube, {0.9, -0.3, 5.6});  // the other end
  picks[0] = wrong;
  const std::vector<std::string> warnings = CheckLandmarks(picks, tube, tube).warnings;
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_THAT(warnings[0], HasSubstr("landmark 'p0' contradicts most others"));
}

TEST(CheckLandmarks, LeftAndRightExchangedThroughoutIsAMirrorImage) {
  const Mesh tube = FineTube();
  std::vector<PickedPair> picks;
  for (std::size_t k = 0; k < kPlaces.size(); ++k) {
    Eigen::RowVector3d other = kPlaces[k];
    other.x() *= -1;
    picks.push_back(PickAt("p" + std::to_string(k), tube, kPlaces[k], tube, other));
  }
  const std::vector<std::string> warnings = CheckLandmarks(picks, tube, tube).warnings;
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_THAT(warnings[0], HasSubstr("mirror image"));
}

TEST(CheckLandmarks, CoplanarAndRepeatedPairsAreTold) {
  const Mesh tube = FineTube();
  std::vector<PickedPair> picks;
  for (const double z : {0.6, 2.0, 3.4, 5.2})
    for (const double x : {-1.0, 1.0})
      picks.push_back(
          PickAt("at " + std::to_string(z) + std::to_string(x), tube, {x, 0, z}, tube, {x, 0, z}));
  picks.push_back(picks[2]);
  picks.back().name = "again";
  const CheckedLandmarks checked = CheckLandmarks(picks, tube, tube);
  EXPECT_TRUE(checked.coplanar);
  EXPECT_EQ(checked.duplicates, 1);
  EXPECT_EQ(checked.goals.size(), picks.size() - 1);
}

void ExpectRefused(const std::vector<PickedPair>& picks, const Mesh& source, const Mesh& target,
                   const std::string& words) {
  try {
    CheckLandmarks(picks, source, target);
    ADD_FAILURE() << "accepted; expected: " << words;
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr(words));
  }
}

TEST(CheckLandmarks, ImpossiblePairsAreErrorsThatNameThem) {
  const Mesh tube = FineTube(), small = MakeBox(1, 1, 1);
  std::vector<PickedPair> picks = Honest(tube, tube, {1, 1, 1});
  picks[3].source_barycentric = {0.7, 0.7, -0.4};
  ExpectRefused(picks, tube, tube, "'p3' lies off face");
  picks = Honest(tube, tube, {1, 1, 1});
  picks[2].target_barycentric[0] = std::nan("");
  ExpectRefused(picks, tube, tube, "'p2' lies off face");
  ExpectRefused(Honest(tube, tube, {1, 1, 1}), tube, small, "picked on another mesh");
  picks = Honest(tube, tube, {1, 1, 1});
  picks.push_back(PickAt("two places", tube, kPlaces[0], tube, kPlaces[6]));
  ExpectRefused(picks, tube, tube, "'p0' and 'two places' are the same point of the source");
}

TEST(CheckLandmarks, DropsRepeatsAndRefusesContradictions) {
  const Mesh mesh = MakeIcosphere(1);
  const Eigen::Vector3d corner(1, 0, 0);
  const PickedPair a{"a", 0, 0, corner, corner}, again{"b", 0, 0, corner, corner},
      against{"c", 0, 50, corner, corner};
  EXPECT_EQ(CheckLandmarks({a, again}, mesh, mesh).duplicates, 1);
  EXPECT_EQ(CheckLandmarks({a, again}, mesh, mesh).goals.size(), 1u);
  try {
    CheckLandmarks({a, against}, mesh, mesh);
    FAIL() << "contradiction accepted";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("'a' and 'c'"), std::string::npos);
  }
  EXPECT_THROW(CheckLandmarks({{"off", 9001, 0, corner, corner}}, mesh, mesh), InputError);
  EXPECT_THROW(CheckLandmarks({{"off", 0, 0, {2, -1, 0}, corner}}, mesh, mesh), InputError);
}

}  // namespace keypose::registration::landmarks_test
