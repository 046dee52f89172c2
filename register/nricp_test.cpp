#include "register/nricp/nricp.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include "core/io/project/stiffness_map.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"
#include "register/landmarks/landmarks.h"
#include "register/nricp/alignment.h"
#include "register/quality/registration_quality.h"
#include "register/testing/scenes.h"

namespace keypose::registration::nricp_test {

/// A body without symmetry: a sphere with smooth bumps.
Mesh Bumpy(int levels) {
  Mesh mesh = MakeIcosphere(levels);
  for (Eigen::Index i = 0; i < mesh.points.rows(); ++i) {
    const Eigen::Vector3d p = mesh.points.row(i);
    mesh.points.row(i) = p.transpose() * (1 + 0.25 * std::sin(2 * p.x() + 1) +
                                          0.35 * std::cos(3 * p.y() + 0.5 * p.x()) + 0.3 * p.z());
  }
  return mesh;
}

TEST(RegisterNricp, MeshOntoItselfIsLeftAloneInOneSolveARound) {
  const Mesh mesh = Bumpy(3);
  const NricpOptions options;
  const NricpResult result = RegisterNricp(mesh, mesh, Every(60, mesh.points), {}, options);
  EXPECT_EQ(result.iterations, options.alpha_steps);
  EXPECT_LT((result.points - mesh.points).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_EQ(result.alignment.method, "procrustes");
}

TEST(RegisterNricp, TranslatingBothMeshesTranslatesTheResult) {
  const Mesh source = MakeIcosphere(2);
  Mesh target = Bumpy(3);
  const auto goals = [&](const Eigen::RowVector3d& shift) {
    std::vector<LandmarkGoal> list;
    for (int i = 0; i < 42; i += 4) list.push_back(At(i, target.points.row(i) + shift));
    return list;
  };
  NricpOptions options;
  options.alpha_min = 1;
  // conjugate gradients stop at a tolerance, so rounding would change the result
  options.exact_solves = true;
  const PointsX3 before = RegisterNricp(source, target, goals({0, 0, 0}), {}, options).points;
  const Eigen::RowVector3d shift(3, -2, 5);
  Mesh moved_source = source, moved_target = target;
  moved_source.points.rowwise() += shift;
  moved_target.points.rowwise() += shift;
  const PointsX3 after =
      RegisterNricp(moved_source, moved_target, goals(shift), {}, options).points;
  EXPECT_LT((after - (before.rowwise() + shift)).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(RegisterNricp, AnalysesOnceAndRefactorsSeldom) {
  const Mesh source = MakeIcosphere(3);
  const NricpResult result = RegisterNricp(source, Bumpy(3), {}, {}, {});
  EXPECT_EQ(result.analyses, 1);
  EXPECT_LT(result.factorisations, result.iterations);
  NricpOptions exact;
  exact.exact_solves = true;
  EXPECT_EQ(RegisterNricp(source, Bumpy(3), {}, {}, exact).analyses, 1);
}

TEST(RegisterNricp, ConjugateGradientsChangeNothingThatMatters) {
  const Mesh tube = MakeCylinder(0.12, 2, 20, 40), fine = MakeCylinder(0.12, 2, 23, 47);
  Mesh target = fine;
  target.points = Bent(fine.points, 2, 0.7);
  const std::vector<LandmarkGoal> goals = Every(70, Bent(tube.points, 2, 0.7));
  NricpOptions exact;
  exact.exact_solves = true;
  const PointsX3 a = RegisterNricp(tube, target, goals, {}, {}).points,
                 b = RegisterNricp(tube, target, goals, {}, exact).points;
  EXPECT_LT((a - b).rowwise().norm().maxCoeff() / BoundingDiagonal(target.points),
            1e-3);  // the effect of one inner loop more or less
}

TEST(RegisterNricp, FollowsAModestBendWithThirteenLandmarks) {
  const Mesh tube = MakeCylinder(0.12, 2, 20, 40), fine = MakeCylinder(0.12, 2, 23, 47);
  Mesh target = fine;
  target.points = Bent(fine.points, 2, 0.7);
  const PointsX3 truth = Bent(tube.points, 2, 0.7);
  const std::vector<LandmarkGoal> goals = Every(63, truth);
  const NricpResult result = RegisterNricp(tube, target, goals, {}, {});
  const double diagonal = BoundingDiagonal(target.points);
  EXPECT_LT((result.points - truth).rowwise().norm().mean() / diagonal,
            0.01);  // this method reaches 0.0087 on a bulb with a tentacle
  const RegistrationQuality q = MeasureRegistration(tube, result.points, target);
  EXPECT_EQ(q.flipped, 0);
  EXPECT_LT(q.surface_rms, 0.003);
}

TEST(RegisterNricp, SameBitsAtOneAndTwoThreads) {
  const Mesh source = MakeIcosphere(3), target = Bumpy(3);
  SetThreadCount(1);
  const PointsX3 one = RegisterNricp(source, target, {}, {}, {}).points;
  SetThreadCount(2);
  const PointsX3 two = RegisterNricp(source, target, {}, {}, {}).points;
  SetThreadCount(0);
  EXPECT_EQ(one, two);
}

TEST(RegisterNricp, OpenMeshesAndStrayPartsStayFinite) {
  Mesh source = MakeIcosphere(2), target = Bumpy(3);
  target.faces.conservativeResize(target.face_count() / 2, 3);  // half a target, with a boundary
  const int n = source.vertex_count();
  PointsX3 points(2 * n, 3);
  points << source.points, (0.05 * source.points).rowwise() + Eigen::RowVector3d(6, 6, 6);
  FacesX3 faces(2 * source.face_count(), 3);
  faces << source.faces, (source.faces.array() + n).matrix();
  source.points = points;
  source.faces = faces;
  const NricpResult result = RegisterNricp(source, target, Every(20, Bumpy(2).points), {}, {});
  EXPECT_TRUE(result.points.allFinite());
  EXPECT_LT(result.kept, 1);
}

TEST(RegisterNricp, StiffPartsBendLess) {
  const Mesh tube = MakeCylinder(0.12, 2, 16, 30);
  Mesh target = tube;
  target.points = Bent(tube.points, 2, 0.6);
  Eigen::VectorXd stiffness = Eigen::VectorXd::Ones(tube.vertex_count());
  for (int i = 0; i < tube.vertex_count(); ++i)
    if (tube.points(i, 2) < 1) stiffness[i] = 30;
  const auto bending =
      [&](const PointsX3& p) {  // how far the motion of the lower half is from one affine map
        std::vector<int> low;
        for (int i = 0; i < tube.vertex_count(); ++i)
          if (tube.points(i, 2) < 0.9) low.push_back(i);
        Eigen::MatrixXd before(low.size(), 4), after(low.size(), 3);
        before << tube.points(low, Eigen::all), Eigen::VectorXd::Ones(low.size());
        after = p(low, Eigen::all);
        return (before * before.colPivHouseholderQr().solve(after) - after).norm();
      };
  NricpOptions options;
  options.alpha_min = 1;
  const std::vector<LandmarkGoal> goals = Every(50, target.points);
  const PointsX3 plain = RegisterNricp(tube, target, goals, {}, options).points,
                 held = RegisterNricp(tube, target, goals, stiffness, options).points;
  EXPECT_LT(bending(held), 0.5 * bending(plain));
}

TEST(RegisterNricp, BadMeshesThrowInputError) {
  const Mesh good = MakeIcosphere(1);
  Mesh empty, nan = good, point = good;
  nan.points(3, 1) = std::numeric_limits<double>::quiet_NaN();
  point.points.setConstant(1);
  EXPECT_THROW(RegisterNricp(empty, good, {}, {}, {}), InputError);
  EXPECT_THROW(RegisterNricp(good, empty, {}, {}, {}), InputError);
  EXPECT_THROW(RegisterNricp(nan, good, {}, {}, {}), InputError);
  EXPECT_THROW(RegisterNricp(good, nan, {}, {}, {}), InputError);
  EXPECT_THROW(RegisterNricp(point, good, {}, {}, {}), InputError);
  EXPECT_THROW(RegisterNricp(good, point, {}, {}, {}), InputError);
  EXPECT_THROW(RegisterNricp(good, good, {At(999, {0, 0, 0})}, {}, {}), InputError);
  EXPECT_THROW(RegisterNricp(good, good, {}, Eigen::VectorXd::Zero(good.vertex_count()), {}),
               InputError);
}

TEST(AlignGlobally, FindsATurnWithoutLandmarks) {
  const Mesh source = Bumpy(3);
  Mesh target = Bumpy(3);
  Similarity3 truth;
  truth.rotation =
      Eigen::AngleAxisd(1.8, Eigen::Vector3d(0.1, -0.2, 1).normalized()).toRotationMatrix();
  truth.scale = 1.4;
  truth.translation << 3, 4, 5;
  target.points = Transformed(truth, source.points);
  const Alignment found = AlignGlobally(source, target, {}, {});
  EXPECT_EQ(found.method, "icp");
  const PointsX3 moved = Transformed(found.target_from_source, source.points);
  EXPECT_LT((moved - target.points).rowwise().norm().mean() / BoundingDiagonal(target.points),
            0.02);  // 500 samples: their spacing is 0.04
}

TEST(AlignGlobally, OneLandmarkDecidesBetweenSymmetricPoses) {
  const Mesh box = MakeBox(1, 2, 4);
  PointsX3 a(1, 3), b(1, 3);
  a << 1, 2, 4;
  b << 0, 0, 4;  // half a turn about z
  const Alignment found = AlignGlobally(box, box, a, b);
  EXPECT_EQ(found.method, "icp with landmarks");
  EXPECT_LT((found.target_from_source * Eigen::Vector3d(1, 2, 4) - Eigen::Vector3d(0, 0, 4)).norm(),
            0.1);
}

TEST(AlignGlobally, LandmarksThatMirrorStillGiveARotation) {
  const Mesh mesh = Bumpy(1);
  PointsX3 mirrored = mesh.points;
  mirrored.col(0) *= -1;
  EXPECT_GT(
      AlignGlobally(mesh, mesh, mesh.points, mirrored).target_from_source.rotation.determinant(),
      0.999);
}

TEST(SpreadRank, TellsPointLinePlaneAndSpace) {
  PointsX3 p(4, 3);
  p << 0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0;
  EXPECT_EQ(SpreadRank(p), 1);
  p(3, 1) = 2;
  EXPECT_EQ(SpreadRank(p), 2);
  p(1, 2) = 2;
  EXPECT_EQ(SpreadRank(p), 3);
  EXPECT_EQ(SpreadRank(PointsX3::Zero(3, 3)), 0);
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

TEST(ParseStiffness, ReadsNumbersAndNamesTheBadLine) {
  EXPECT_EQ(ParseStiffness("1 2\n# half\n0.5\n", 3, "map.txt")[2], 0.5);
  EXPECT_THROW(ParseStiffness("1 2", 3, "map.txt"), InputError);
  try {
    ParseStiffness("1\n2\n-3\n", 3, "map.txt");
    FAIL() << "negative stiffness accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).rfind("map.txt:3:", 0), 0u);
  }
}

TEST(MeasureRegistration, CountsFlipsAndDistances) {
  const Mesh mesh = MakeIcosphere(3);
  const RegistrationQuality same = MeasureRegistration(mesh, mesh.points, mesh);
  EXPECT_EQ(same.flipped, 0);
  EXPECT_LT(same.surface_rms, 1e-12);
  EXPECT_LT(same.hausdorff_from_target, 1e-12);
  Mesh inside_out = mesh;
  inside_out.faces.col(1).swap(inside_out.faces.col(2));
  EXPECT_EQ(MeasureRegistration(mesh, mesh.points, inside_out).flipped, mesh.face_count());
  const RegistrationQuality grown = MeasureRegistration(mesh, 1.1 * mesh.points, mesh);
  EXPECT_NEAR(grown.hausdorff_to_target, 0.1 / BoundingDiagonal(mesh.points), 1e-3);
  EXPECT_NEAR(grown.surface_rms, 0.1 / BoundingDiagonal(mesh.points), 1e-3);
}

}  // namespace keypose::registration::nricp_test
