// The default method on holes, cropped targets, tiny, flat and wrong meshes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/camera.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "register/auto/auto_registration.h"
#include "register/testing/scenes.h"
#include "register/testing/tubes.h"

namespace keypose::registration::imperfect_meshes_test {

using Eigen::RowVector3d;

/// Removes the faces whose centre at rest satisfies `gone`, and the vertices that are then unused.
template <class Gone>
Mesh Without(const Mesh& rest, const PointsX3& posed, const Gone& gone) {
  Mesh mesh;
  std::vector<int> index(rest.vertex_count(), -1);
  std::vector<RowVector3d> points;
  std::vector<Eigen::RowVector3i> faces;
  for (Eigen::Index f = 0; f < rest.faces.rows(); ++f) {
    const Eigen::RowVector3i face = rest.faces.row(f);
    if (gone((rest.points.row(face[0]) + rest.points.row(face[1]) + rest.points.row(face[2])) / 3))
      continue;
    for (int k = 0; k < 3; ++k)
      if (index[face[k]] < 0) {
        index[face[k]] = SizeOf(points);
        points.push_back(posed.row(face[k]));
      }
    faces.emplace_back(index[face[0]], index[face[1]], index[face[2]]);
  }
  mesh.points.resize(std::ssize(points), 3);
  for (std::size_t k = 0; k < points.size(); ++k) mesh.points.row(k) = points[k];
  mesh.faces.resize(std::ssize(faces), 3);
  for (std::size_t k = 0; k < faces.size(); ++k) mesh.faces.row(k) = faces[k];
  return mesh;
}

TEST(RegisterAuto, HolesInTheTargetDoNotPull) {
  const Mesh source = Tube(), rest = OtherTube();
  const PointsX3 truth = Bent(source.points, kLength, 1.5);
  const Mesh target = Without(rest, Bent(rest.points, kLength, 1.5), [](const RowVector3d& p) {
    return (p - RowVector3d(kRadius, 0, 0.6)).norm() < 0.12 ||
           (p - RowVector3d(0, -kRadius, 1.3)).norm() < 0.15;
  });
  ASSERT_LT(target.face_count(), rest.face_count());
  const AutoResult result = RegisterAuto(source, target, Every(kGoalStride, truth), {}, {});
  EXPECT_LT(Errors(result.points, truth).mean(), 0.004);
  EXPECT_LT(Errors(result.points, truth).maxCoeff(), 0.03);
  EXPECT_EQ(Inverted(source.faces, result.points, truth), 0);
}

TEST(RegisterAuto, AnOpenTemplateFollowsToo) {
  const Mesh tube = Tube(), rest = OtherTube();
  const Mesh source = Without(tube, tube.points, [](const RowVector3d& p) {
    return p.z() < 0.01 || p.z() > kLength - 0.01 ||
           (p - RowVector3d(kRadius, 0, 0.7)).norm() < 0.1;
  });
  ASSERT_LT(source.face_count(), tube.face_count());
  const PointsX3 truth = Bent(source.points, kLength, 1.5);
  const AutoResult result = RegisterAuto(source, WithPoints(rest, Bent(rest.points, kLength, 1.5)),
                                         Every(kGoalStride, truth), {}, {});
  EXPECT_LT(Errors(result.points, truth).mean(), 0.004);
  EXPECT_LT(Errors(result.points, truth).maxCoeff(), 0.02);
  EXPECT_EQ(Inverted(source.faces, result.points, truth), 0);
}

TEST(RegisterAuto, ACroppedTargetDoesNotSquashWhatIsLeft) {
  const Mesh source = Tube(), rest = OtherTube();
  const PointsX3 truth = Bent(source.points, kLength, 1.5);
  const Mesh target = Without(rest, Bent(rest.points, kLength, 1.5),
                              [](const RowVector3d& p) { return p.z() > 1.4; });
  std::vector<LandmarkGoal> goals;
  for (const LandmarkGoal& goal : Every(31, truth))
    if (PositionOf(goal.source, source.points).z() < 1.3) goals.push_back(goal);
  const AutoResult result = RegisterAuto(source, target, goals, {}, {});
  const Eigen::VectorXd errors = Errors(result.points, truth);
  double seen = 0, unseen = 0, count = 0;
  for (int v = 0; v < source.vertex_count(); ++v) {
    if (source.points(v, 2) < 1.3)
      seen += errors[v], ++count;
    else
      unseen = std::max(unseen, errors[v]);
  }
  EXPECT_LT(seen / count, 0.005);
  EXPECT_LT(unseen, 0.3);
}

TEST(RegisterAuto, TinyAndFlatMeshesFinish) {
  Mesh tetrahedron;
  tetrahedron.points.resize(4, 3);
  tetrahedron.points << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  tetrahedron.faces.resize(4, 3);
  tetrahedron.faces << 0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2;
  Mesh square;
  square.points.resize(4, 3);
  square.points << 0, 0, 0, 1, 0, 0, 1, 2, 0, 0, 2, 0;
  square.faces.resize(2, 3);
  square.faces << 0, 1, 2, 0, 2, 3;
  const Mesh ball = MakeIcosphere(0), box = MakeBox(1, 2, 3), fine = MakeIcosphere(3);
  for (const Mesh& source : {tetrahedron, square, ball, box}) {
    for (const Mesh& target : {tetrahedron, square, ball, box, fine})
      EXPECT_TRUE(RegisterAuto(source, target, Every(1, target.points.topRows(4)), {}, {})
                      .points.allFinite());
  }
  EXPECT_TRUE(RegisterAuto(square, ball, {}, {}, {}).points.allFinite());
  EXPECT_TRUE(
      RegisterAuto(tetrahedron, box, {At(0, box.points.row(0))}, {}, {}).points.allFinite());
  EXPECT_LT(Errors(RegisterAuto(tetrahedron, tetrahedron, {}, {}, {}).points, tetrahedron.points)
                .maxCoeff(),
            1e-3);
}

TEST(RegisterAuto, SilentDuplicatesAndStrayVerticesDoNoHarm) {
  Mesh source = Tube(), target = OtherTube();
  target.points = Bent(target.points, kLength, 1);
  const int n = source.vertex_count();
  const PointsX3 truth = Bent(source.points, kLength, 1);
  source.points.conservativeResize(n + 1, 3);
  source.points.row(n) << 1, 1, 1;  // in no face
  const Eigen::Index faces = source.faces.rows();
  source.faces.conservativeResize(faces + 2, 3);
  source.faces.row(faces) = source.faces.row(10);  // twice
  source.faces.row(faces + 1) << 5, 5, 6;          // without area
  const AutoResult result = RegisterAuto(source, target, Every(kGoalStride, truth), {}, {});
  EXPECT_TRUE(result.points.allFinite());
  EXPECT_LT(Errors(result.points.topRows(n), truth).mean(), 0.002);
}

TEST(RegisterAuto, BadInputThrowsAndSaysWhere) {
  const Mesh good = MakeIcosphere(1);
  Mesh empty, nan = good, point = good, three;
  nan.points(3, 1) = std::numeric_limits<double>::quiet_NaN();
  point.points.setConstant(1);
  three.points = PointsX3::Identity(3, 3);
  three.faces.resize(1, 3);
  three.faces << 0, 1, 2;
  const auto words = [](const Mesh& source, const Mesh& target,
                        const std::vector<LandmarkGoal>& goals, const Eigen::VectorXd& stiffness) {
    try {
      RegisterAuto(source, target, goals, stiffness, {});
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  const auto contains = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_TRUE(contains(words(empty, good, {}, {}), "source"));
  EXPECT_TRUE(contains(words(good, empty, {}, {}), "target"));
  EXPECT_TRUE(contains(words(nan, good, {}, {}), "vertex 3"));
  EXPECT_TRUE(contains(words(good, nan, {}, {}), "vertex 3"));
  EXPECT_TRUE(contains(words(point, good, {}, {}), "area"));
  EXPECT_TRUE(contains(words(good, point, {}, {}), "area"));
  EXPECT_TRUE(contains(words(three, good, {}, {}), "fewer than 4"));
  EXPECT_TRUE(contains(words(good, good, {At(999, {0, 0, 0})}, {}), "999"));
  EXPECT_TRUE(contains(words(good, good, {At(-1, {0, 0, 0})}, {}), "-1"));
  EXPECT_TRUE(contains(words(good, good, {At(1, {0, NAN, 0})}, {}), "landmark"));
  EXPECT_TRUE(contains(words(good, good, {}, Eigen::VectorXd::Ones(5)), "5 values"));
  EXPECT_TRUE(
      contains(words(good, good, {}, Eigen::VectorXd::Zero(good.vertex_count())), "above 0"));
  Eigen::VectorXd not_numbers = Eigen::VectorXd::Ones(good.vertex_count());
  not_numbers[2] = NAN;
  EXPECT_TRUE(contains(words(good, good, {}, not_numbers), "above 0"));
}

}  // namespace keypose::registration::imperfect_meshes_test
