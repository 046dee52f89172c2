// Registration by the default method against known truth.
#include "register/auto/auto_registration.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <limits>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "core/camera.h"
#include "core/errors.h"
#include "core/geometry.h"
#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/io/mesh_io.h"
#include "core/parallel.h"
#include "core/size_of.h"
#include "core/testing_shapes.h"
#include "register/testing/scenes.h"

namespace keypose::registration {
namespace {

using Eigen::RowVector3d;
using Eigen::Vector3d;

/// A ball with three different limbs: no two places look the same, and its mirror image is another
/// shape.
Mesh Body(int levels, const Eigen::Matrix3d& tessellation = Eigen::Matrix3d::Identity()) {
  const std::pair<Vector3d, double> limbs[] = {
      {{0.1, 1, 0.5}, 0.9}, {{0.9, -0.6, 0.2}, 1.3}, {{-0.7, -0.2, -0.7}, 0.6}};
  Mesh mesh = MakeIcosphere(levels);
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) {
    const Vector3d direction = (tessellation * mesh.points.row(v).transpose()).normalized();
    double radius = 0.4;
    for (const auto& [toward, length] : limbs)
      radius += length * std::exp(12 * (direction.dot(toward.normalized()) - 1));
    mesh.points.row(v) = radius * direction.transpose();
  }
  return mesh;
}

constexpr double kRadius = 0.12, kLength = 2;
constexpr int kSegments = 20, kRings = 40, kGoalStride = 63;
Mesh Tube() { return MakeCylinder(kRadius, kLength, kSegments, kRings); }
Mesh OtherTube() { return MakeCylinder(kRadius, kLength, 23, 47); }

Mesh WithPoints(Mesh mesh, const PointsX3& points) {
  mesh.points = points;
  return mesh;
}

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

Eigen::VectorXd Errors(const PointsX3& found, const PointsX3& truth) {
  return (found - truth).rowwise().norm() / BoundingDiagonal(truth);
}

/// Number of faces whose normal opposes that of the true face.
int Inverted(const FacesX3& faces, const PointsX3& found, const PointsX3& truth) {
  return static_cast<int>(
      (FaceNormals(found, faces).cwiseProduct(FaceNormals(truth, faces)).rowwise().sum().array() <=
       0)
          .count());
}

TEST(RegisterAuto, MeshOntoItselfStaysInPlace) {
  for (const Mesh& mesh : {Body(3), Tube(), MakeBox(1, 2, 3)}) {
    const Eigen::VectorXd errors = Errors(RegisterAuto(mesh, mesh, {}, {}, {}).points, mesh.points);
    EXPECT_LT(errors.mean(), 1e-3);
    EXPECT_LT(errors.maxCoeff(), 2e-3);
  }
}

TEST(RegisterAuto, FindsAnyTurnAndSizeWithoutLandmarks) {
  // The last target has other vertices. Its facets differ from the source by 0.007 where limbs are
  // thin.
  const Mesh other =
      Body(3, Eigen::AngleAxisd(0.4, Vector3d(3, 1, 2).normalized()).toRotationMatrix());
  const Eigen::AngleAxisd turns[] = {{M_PI, Vector3d::UnitX()},
                                     {M_PI, Vector3d(1, 2, -1).normalized()},
                                     {2.2, Vector3d(-1, 0.3, 1).normalized()},
                                     {1.3, Vector3d(0.2, 1, 1).normalized()}};
  const double scales[] = {0.01, 100, 1, 1};
  for (int k = 0; k < 4; ++k) {
    Similarity3 truth;
    truth.rotation = turns[k].toRotationMatrix();
    truth.scale = scales[k];
    truth.translation = truth.scale * Vector3d(7, -20, 3);
    const Mesh source = Body(k < 3 ? 2 : 3), target = k < 3 ? source : other;
    const AutoResult result =
        RegisterAuto(source, WithPoints(target, Transformed(truth, target.points)), {}, {}, {});
    const PointsX3 expected = Transformed(truth, source.points);
    EXPECT_LT(Errors(result.points, expected).mean(), k < 3 ? 5e-4 : 0.01) << "turn " << k;
    EXPECT_NEAR(result.scale / truth.scale, 1, 0.02) << "turn " << k;
    EXPECT_EQ(Inverted(source.faces, result.points, expected), 0) << "turn " << k;
  }
}

class BentTube : public testing::TestWithParam<int> {};

TEST_P(BentTube, IsFollowedWithLandmarks) {
  const double angle = GetParam() * M_PI / 180;
  const Mesh source = Tube(), rest = OtherTube();
  const PointsX3 truth = Bent(source.points, kLength, angle);
  const AutoResult result =
      RegisterAuto(source, WithPoints(rest, Bent(rest.points, kLength, angle)),
                   Every(kGoalStride, truth), {}, {});
  EXPECT_LT(Errors(result.points, truth).mean(), 0.003);
  EXPECT_EQ(Inverted(source.faces, result.points, truth), 0);
  EXPECT_EQ(result.alignment.method, "procrustes");
  EXPECT_EQ(result.points.rows(), source.points.rows());
  ASSERT_LT(static_cast<std::size_t>(result.chosen), result.starts.size());
}

INSTANTIATE_TEST_SUITE_P(Degrees, BentTube, testing::Values(40, 90, 140, 180, 230, 270));

// A landmark 4 % of the diagonal off the surface contradicts it.
TEST(RegisterAuto, HeavierLandmarksAreMetMoreClosely) {
  const Mesh mesh = Body(3);
  std::vector<LandmarkGoal> goals = Every(kGoalStride, mesh.points);
  goals[0].target *= 1 + 0.04 * BoundingDiagonal(mesh.points) / goals[0].target.norm();
  const auto left = [&](double start, double end) {
    AutoOptions options;
    options.landmark_weight = start;
    options.landmark_weight_end = end;
    const PointsX3 found = RegisterAuto(mesh, mesh, goals, {}, options).points;
    return (PositionOf(goals[0].source, found) - goals[0].target).norm();
  };
  EXPECT_LT(left(1000, 1000), 0.5 * left(50, 0.05));
  EXPECT_NE(left(1000, 5), left(1, 5));
}

TEST(RegisterAuto, PoorFitDecidesHowManyStartsAreTried) {
  const Mesh source = Tube(), rest = OtherTube();
  const Mesh target = WithPoints(rest, Bent(rest.points, kLength, 2.5));
  const auto starts = [&](double poor_fit) {
    AutoOptions options;
    options.good_fit = std::min(options.good_fit, poor_fit);
    options.poor_fit = poor_fit;
    return RegisterAuto(source, target, {}, {}, options).starts.size();
  };
  EXPECT_LT(starts(1), starts(1e-7));
}

TEST(RegisterAuto, SmootherMapsStretchMoreEvenly) {
  const Mesh source = Tube();
  const PointsX3 truth = Bent(source.points, kLength, 1.5);
  const auto points = [&](double smoothing) {
    AutoOptions options;
    options.smoothing = smoothing;
    return RegisterAuto(source, WithPoints(OtherTube(), Bent(OtherTube().points, kLength, 1.5)),
                        Every(kGoalStride, truth), {}, options)
        .points;
  };
  EXPECT_NE(points(0), points(0.1));
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

/// Bends a body about one axis by an angle that grows along another.
PointsX3 Twisted(const PointsX3& points) {
  PointsX3 twisted = points;
  for (Eigen::Index v = 0; v < points.rows(); ++v)
    twisted.row(v) = (Eigen::AngleAxisd(0.6 * points(v, 1), Vector3d(1, 0, 0.4).normalized()) *
                      points.row(v).transpose())
                         .transpose();
  return twisted;
}

TEST(RegisterAuto, MovesWithItsInputs) {
  const Mesh source = Body(3),
             rest =
                 Body(3, Eigen::AngleAxisd(0.4, Vector3d(3, 1, 2).normalized()).toRotationMatrix());
  const Mesh target = WithPoints(rest, Twisted(rest.points));
  const PointsX3 truth = Twisted(source.points);
  const PointsX3 before = RegisterAuto(source, target, Every(60, truth), {}, {}).points;
  EXPECT_LT(Errors(before, truth).mean(), 0.01);
  const auto moved = [&](const Similarity3& of_source, const Similarity3& of_target) {
    std::vector<LandmarkGoal> goals = Every(60, Transformed(of_target, truth));
    return RegisterAuto(WithPoints(source, Transformed(of_source, source.points)),
                        WithPoints(target, Transformed(of_target, target.points)), goals, {}, {})
        .points;
  };
  Similarity3 of_source, of_target;
  of_source.scale = 30;
  of_source.translation << 5, 6, -7;
  of_source.rotation << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  of_target.scale = 0.2;
  of_target.translation << -1, 3, 2;
  of_target.rotation << 0, 0, -1, -1, 0, 0, 0, 1,
      0;  // keeps the bounding diagonal, by which lengths are judged
  EXPECT_LT(Errors(moved(of_source, of_target), Transformed(of_target, before)).maxCoeff(), 1e-6);
  of_target.rotation = Eigen::AngleAxisd(2.3, Vector3d(1, -1, 2).normalized()).toRotationMatrix();
  EXPECT_LT(Errors(moved(of_source, of_target), Transformed(of_target, before)).maxCoeff(), 0.01);
}

/// How far the motion of the vertices is from one similarity transform.
double Deformation(const PointsX3& before, const PointsX3& after,
                   const std::vector<int>& vertices) {
  const PointsX3 a = before(vertices, Eigen::all), b = after(vertices, Eigen::all);
  return (Transformed(FitSimilarity(a, b), a) - b).norm();
}

TEST(RegisterAuto, StiffPartsKeepTheirShapeBetter) {
  const Mesh tube = Tube();
  Mesh target = OtherTube();
  target.points = Bent(target.points, kLength, 0.8);
  const PointsX3 truth = Bent(tube.points, kLength, 0.8);
  Eigen::VectorXd stiffness = Eigen::VectorXd::Ones(tube.vertex_count());
  std::vector<int> low;
  for (int v = 0; v < tube.vertex_count(); ++v)
    if (tube.points(v, 2) < 1) {
      stiffness[v] = 300;
      low.push_back(v);
    }
  const PointsX3 plain = RegisterAuto(tube, target, Every(kGoalStride, truth), {}, {}).points;
  const PointsX3 held = RegisterAuto(tube, target, Every(kGoalStride, truth), stiffness, {}).points;
  EXPECT_LT(Deformation(tube.points, held, low), 0.9 * Deformation(tube.points, plain, low));
}

TEST(RegisterAuto, ALooseBallFollowsWithoutChangingShape) {
  const Mesh tube = Tube();
  Mesh ball = MakeIcosphere(2);
  const double size = 0.05;
  ball.points = (size * ball.points).rowwise() + RowVector3d(kRadius, 0, 1.5);
  const Mesh source = Joined(tube, ball);
  const double angle = 2;
  const PointsX3 truth = Bent(tube.points, kLength, angle);
  Mesh target = OtherTube();
  target.points = Bent(target.points, kLength, angle);
  const AutoResult result = RegisterAuto(source, target, Every(kGoalStride, truth), {}, {});
  EXPECT_EQ(result.loose_parts, 1);
  EXPECT_LT(Errors(result.points.topRows(tube.vertex_count()), truth).mean(), 0.003);
  // A rigid motion: the ball's centre follows the bend, and the ball is rotated by the bend's angle
  // there.
  const PointsX3 found = result.points.bottomRows(ball.vertex_count());
  PointsX3 centre(1, 3);
  centre << kRadius, 0, 1.5;
  EXPECT_LT(
      (found.colwise().mean() - Bent(centre, kLength, angle)).norm() / BoundingDiagonal(truth),
      0.003);
  const Similarity3 motion = FitSimilarity(ball.points, found);
  EXPECT_LT((Transformed(motion, ball.points) - found).rowwise().norm().maxCoeff(), 0.01 * size);
  EXPECT_NEAR(motion.scale, 1, 0.1);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(angle * 1.5 / kLength, Vector3d::UnitY()).toRotationMatrix();
  EXPECT_LT(Eigen::AngleAxisd(motion.rotation.transpose() * turn).angle(), 0.05);
  for (int v = tube.vertex_count(); v < source.vertex_count(); ++v)
    EXPECT_LT((result.transforms[v] - motion.scale * motion.rotation).norm(), 1e-6);
}

TEST(RegisterAuto, TransformsCarryEachNeighbourhood) {
  const Mesh source = Tube(), rest = OtherTube();
  const double angle = 2.5;
  const PointsX3 truth = Bent(source.points, kLength, angle);
  Similarity3 grow;
  grow.scale = 3;
  grow.rotation = Eigen::AngleAxisd(1, Vector3d::UnitZ()).toRotationMatrix();
  const Mesh target = WithPoints(rest, Transformed(grow, Bent(rest.points, kLength, angle)));
  const AutoResult result =
      RegisterAuto(source, target, Every(kGoalStride, Transformed(grow, truth)), {}, {});
  ASSERT_EQ(result.transforms.size(), static_cast<std::size_t>(source.vertex_count()));
  double misfit = 0, length = 0;
  for (int v = 0; v < source.vertex_count(); ++v) {
    ASSERT_TRUE(result.transforms[v].allFinite());
    EXPECT_NEAR(result.transforms[v].determinant(), 27, 9);
  }
  for (const auto& [i, j] : UndirectedEdges(source.faces)) {
    const Vector3d edge = (result.points.row(j) - result.points.row(i)).transpose();
    misfit +=
        (result.transforms[i] * (source.points.row(j) - source.points.row(i)).transpose() - edge)
            .norm();
    length += edge.norm();
  }
  EXPECT_LT(misfit / length, 0.1);
}

/// A tube bent by 46 degrees, with few landmarks, so that other starts are tried too.
AutoResult BentByFewLandmarks(const AutoOptions& options) {
  constexpr double kAngle = 0.8;
  const Mesh source = Tube(), target = WithPoints(source, Bent(source.points, kLength, kAngle));
  const std::vector<LandmarkGoal> all = Every(kGoalStride, target.points);
  return RegisterAuto(source, target, {all.front(), all[all.size() / 2], all.back()}, {}, options);
}

TEST(RegisterAuto, AStartThatLosesLeavesNothingButItsTrial) {
  AutoOptions one_start, more_starts;
  one_start.suggest = one_start.skeleton = false;
  const AutoResult alone = BentByFewLandmarks(one_start), among = BentByFewLandmarks(more_starts);
  ASSERT_EQ(alone.starts.size(), 1u);
  ASSERT_GT(among.starts.size(), 1u);
  ASSERT_EQ(among.chosen, 0);
  // Each start scales the rest shape by a factor from the size before, and these factors round.
  constexpr double kRounding = 1e-12;
  EXPECT_LT((among.points - alone.points).cwiseAbs().maxCoeff(), kRounding);
  EXPECT_NEAR(among.gap, alone.gap, kRounding);
  EXPECT_NEAR(among.scale, alone.scale, kRounding);
  EXPECT_EQ(among.softened, alone.softened);
  EXPECT_EQ(among.starts[0].gap, alone.starts[0].gap);
  EXPECT_EQ(among.starts[0].score, alone.starts[0].score);
}

TEST(RegisterAuto, SameBitsAtOneAndTwoThreads) {
  const Mesh source = Tube(), body = Body(2);
  Mesh target = OtherTube(),
       other = Body(2, Eigen::AngleAxisd(0.4, Vector3d::UnitX()).toRotationMatrix());
  target.points = Bent(target.points, kLength, 1.2);
  other.points = Twisted(other.points);
  std::vector<AutoResult> with, without;
  for (const int threads : {1, 2}) {
    SetThreadCount(threads);
    with.push_back(RegisterAuto(source, target,
                                Every(kGoalStride, Bent(source.points, kLength, 1.2)), {}, {}));
    without.push_back(RegisterAuto(body, other, {}, {}, {}));
  }
  SetThreadCount(0);
  EXPECT_EQ(with[0].points, with[1].points);
  EXPECT_EQ(with[0].transforms, with[1].transforms);
  EXPECT_EQ(without[0].points, without[1].points);
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

TEST(RegisterAuto, CancelsWithinTheRun) {
  class Stop : public Progress {
   public:
    void Update(double fraction, std::string_view) override { last = fraction; }
    bool cancelled() const override { return last > 0.3; }
    double last = 0;
  } stop;
  EXPECT_THROW(RegisterAuto(Tube(), OtherTube(), {}, {}, {}, &stop), Cancelled);
}

class Program : public testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        std::filesystem::temp_directory_path() / ("keypose_auto_test_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    WriteMesh(folder_ / "source.ply", MakeCylinder(kRadius, kLength, 12, 20));
    target_ = MakeCylinder(kRadius, kLength, 13, 23);
    target_.points = Bent(target_.points, kLength, 1);
    WriteMesh(folder_ / "target.ply", target_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  int Run(const std::string& arguments) {
    const std::string line = "cd '" + folder_.string() +
                             "' && '" KEYPOSE_BIN_DIR "/keypose-register' --target target.ply " +
                             arguments + " > log.txt 2>&1";
    const int status = std::system(line.c_str());
    log_ = ReadFile(folder_ / "log.txt");
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  bool Wrote(const std::string& name) const { return std::filesystem::exists(folder_ / name); }

  std::filesystem::path folder_;
  Mesh target_;
  std::string log_;
};

/// The numbers of each line that is not a comment.
std::vector<std::vector<double>> Table(const std::string& text) {
  std::vector<std::vector<double>> rows;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream words(line);
    rows.emplace_back();
    for (double x; words >> x;) rows.back().push_back(x);
  }
  return rows;
}

TEST_F(Program, WritesCorrespondenceTransformsAndPicture) {
  ASSERT_EQ(Run("--source source.ply --registered out.ply --correspondence c.txt --transforms "
                "t.txt --picture p.png"),
            0)
      << log_;
  const Mesh source = ReadMesh(folder_ / "source.ply"), out = ReadMesh(folder_ / "out.ply");
  EXPECT_EQ(out.faces, source.faces);
  const auto correspondence = Table(ReadFile(folder_ / "c.txt")),
             transforms = Table(ReadFile(folder_ / "t.txt"));
  ASSERT_EQ(correspondence.size(), static_cast<std::size_t>(source.vertex_count()));
  ASSERT_EQ(transforms.size(), static_cast<std::size_t>(source.vertex_count()));
  const double diagonal = BoundingDiagonal(target_.points);
  for (int v = 0; v < source.vertex_count(); ++v) {
    const std::vector<double>& c = correspondence[v];
    ASSERT_EQ(c.size(), 5u);
    ASSERT_TRUE(c[0] >= 0 && c[0] < target_.face_count());
    EXPECT_NEAR(c[1] + c[2] + c[3], 1, 1e-6);
    RowVector3d foot = RowVector3d::Zero();
    for (int k = 0; k < 3; ++k)
      foot += c[1 + k] * target_.points.row(target_.faces(static_cast<int>(c[0]), k));
    EXPECT_NEAR((foot - out.points.row(v)).norm() / diagonal, c[4], 1e-5);
    EXPECT_LT(c[4], 0.02);
    ASSERT_EQ(transforms[v].size(), 12u);
    const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> map(transforms[v].data());
    EXPECT_LT((map * source.points.row(v).transpose().homogeneous() - out.points.row(v).transpose())
                  .norm(),
              1e-5);
    EXPECT_GT(map.leftCols<3>().determinant(), 0);
  }
  const Image8 picture = ReadImage(folder_ / "p.png");
  EXPECT_GT(picture.width, 100);
  EXPECT_GT(picture.height, 100);
}

TEST_F(Program, BadInputHasItsExitCodeAndWritesNothing) {
  WriteFile(folder_ / "short.txt", "1 2 3\n");
  EXPECT_EQ(Run("--source source.ply --stiffness short.txt --registered out.ply"), 3) << log_;
  EXPECT_NE(log_.find("short.txt"), std::string::npos) << log_;
  EXPECT_EQ(Run("--source source.ply --registered out.ply --method magic"), 2) << log_;
  EXPECT_EQ(
      Run("--source source.ply --registered out.ply --coarse_vertices 900 --middle_vertices 100"),
      2)
      << log_;
  WriteFile(folder_ / "three.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_EQ(Run("--source three.obj --registered out.ply"), 3) << log_;
  EXPECT_NE(log_.find("fewer than 4"), std::string::npos) << log_;
  WriteFile(folder_ / "off.txt", "3 99999\n");
  EXPECT_EQ(Run("--source source.ply --landmarks off.txt --registered out.ply"), 3) << log_;
  EXPECT_NE(log_.find("off.txt:1"), std::string::npos) << log_;
  EXPECT_EQ(
      Run("--source source.ply --registered out.ply --correspondence c.txt --max_surface_rms 1e-9"),
      6)
      << log_;
  for (const std::string name : {"out.ply", "c.txt"}) EXPECT_FALSE(Wrote(name)) << name;
}

}  // namespace
}  // namespace keypose::registration
