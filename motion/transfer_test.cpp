#include "motion/transfer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/numbers/parallel.h"
#include "core/numbers/rotations.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "motion/testing/marked_bar.h"
#include "motion/testing/rigged_scan.h"

namespace keypose::motion::transfer_test {

std::vector<Mark> AllMarked(const Mesh& mesh) {
  std::vector<Mark> marks;
  for (int f = 0; f < mesh.face_count(); ++f) marks.push_back(OnBoth(f));
  return marks;
}

double Furthest(const PointsX3& a, const PointsX3& b) {
  return (a - b).rowwise().norm().maxCoeff();
}

/// An open strip of quads along x, each split in two.
Mesh MakeStrip(int quads, double width) {
  Mesh mesh;
  mesh.points.resize(2 * (quads + 1), 3);
  mesh.faces.resize(2 * quads, 3);
  for (int i = 0; i <= quads; ++i) {
    mesh.points.row(2 * i) << i, 0, 0;
    mesh.points.row(2 * i + 1) << i, width, 0.3 * width;
  }
  for (int i = 0; i < quads; ++i) {
    mesh.faces.row(2 * i) << 2 * i, 2 * i + 2, 2 * i + 1;
    mesh.faces.row(2 * i + 1) << 2 * i + 1, 2 * i + 2, 2 * i + 3;
  }
  return mesh;
}

/// The strip folded at its rulings by these angles: each quad stays as it is.
PointsX3 Folded(const Mesh& strip, const std::vector<double>& angles) {
  PointsX3 points = strip.points;
  const Eigen::Vector3d ruling = (strip.points.row(1) - strip.points.row(0)).normalized();
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  for (int i = 0; i < SizeOf(angles); ++i) {
    turn = turn * ExpOf(angles[i] * ruling);
    for (int side = 0; side < 2; ++side)
      points.row(2 * i + 2 + side) =
          points.row(2 * i + side) +
          (turn * (strip.points.row(2 * i + 2 + side) - strip.points.row(2 * i + side)).transpose())
              .transpose();
  }
  return points;
}

TEST(Transfer, AllTrianglesMarkedReproducesFoldedPoses) {
  // A folded strip is the one surface that bends without stretching any triangle.
  const Mesh strip = MakeStrip(12, 2);
  std::vector<PointsX3> poses;
  for (double bend : {0.0, 0.1, 0.35, 0.6}) {
    std::vector<double> angles;
    for (int i = 0; i < 12; ++i) angles.push_back(bend * (i % 3 - 0.4));
    poses.push_back(Folded(strip, angles));
  }
  for (const TransferMethod method :
       {TransferMethod::kAuto, TransferMethod::kPaper, TransferMethod::kLiteral}) {
    TransferOptions options;
    options.method = method;
    const auto result =
        Transferred(strip, strip.points, strip.faces, AllMarked(strip), poses, options);
    for (std::size_t t = 0; t < poses.size(); ++t) EXPECT_LT(Furthest(result[t], poses[t]), 1e-9);
  }
}

/// Points turned about z by an angle that is linear in z: `low` at z = 0, `high` at z = 2.
PointsX3 Twisted(const PointsX3& points, double low, double high) {
  PointsX3 result = points;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const double angle = low + (high - low) * points(i, 2) / 2;
    result.row(i) = points.row(i) * ExpOf({0, 0, angle}).transpose();
  }
  return result;
}

/// The angle about z of a vertex of the bar, against its place at rest.
double AngleAt(const PointsX3& rest, const PointsX3& pose, int i) {
  return std::atan2(rest(i, 0) * pose(i, 1) - rest(i, 1) * pose(i, 0),
                    rest(i, 0) * pose(i, 0) + rest(i, 1) * pose(i, 1));
}

TEST(Transfer, OneMarkMovesAllRigidly) {
  const Mesh bar = MakeBar();
  const PointsX3 pose =
      (bar.points * ExpOf({0.4, -1.1, 2.0}).transpose()).rowwise() + Eigen::RowVector3d(1, 2, 3);
  for (const TransferMethod method :
       {TransferMethod::kAuto, TransferMethod::kPaper, TransferMethod::kLiteral}) {
    TransferOptions options;
    options.method = method;
    options.feet = false;
    options.scale = 1;
    const auto result =
        Transferred(bar, bar.points, bar.faces, MarksAlong(bar, {1.3}), {pose}, options);
    EXPECT_LT(Furthest(result[0], pose), 1e-11);
  }
}

TEST(Transfer, TwoMarksOnABarGiveALinearProfile) {
  const Mesh bar = MakeBar(120);
  TransferOptions options;
  options.feet = options.volume = false;
  const PointsX3 ends = Twisted(bar.points, -kPi / 2, kPi / 2);
  const auto result = Transferred(bar, bar.points, bar.faces, MarksAlong(bar, {0.1, 1.9}),
                                  {bar.points, ends}, options);
  // The field is linear between the marks, but for its ends, where two triangles hold all of a
  // ring: the profile is compared where that has faded, against the line through two of its points.
  const auto angle = [&](double z) {
    double sum = 0;
    int count = 0;
    for (int i = 0; i < bar.vertex_count(); ++i)
      if (std::abs(bar.points(i, 2) - z) < 1e-6 && bar.points.row(i).head<2>().norm() > 0.01)
        sum += AngleAt(bar.points, result[1], i), ++count;
    return sum / count;
  };
  const double low = angle(0.5), high = angle(1.5);
  for (double z = 0.5; z < 1.51; z += 0.1)
    EXPECT_NEAR(angle(z), low + (high - low) * (z - 0.5), 1e-3) << z;
  EXPECT_NEAR(angle(1.0), 0, 1e-3);
  // The marks are small, so the line does not quite reach their values: 1.745 would be all of it.
  EXPECT_GT(high - low, 1.4);
}

TEST(Transfer, LiteralAndFastAgree) {
  const Mesh bar = MakeBar(30);
  const std::vector<Mark> marks = MarksAlong(bar, {0.2, 0.7, 1.1, 1.6, 1.9});
  std::vector<PointsX3> poses;
  for (double bend : {0.0, 0.5, 1.2, 2.5}) {
    PointsX3 pose = Twisted(bar.points, -bend, bend);
    pose.col(0).array() += bend * pose.col(2).array().square() / 3;
    poses.push_back(pose);
  }
  TransferOptions options;
  options.method = TransferMethod::kPaper;
  const auto fast = Transferred(bar, bar.points, bar.faces, marks, poses, options);
  options.method = TransferMethod::kLiteral;
  const auto literal = Transferred(bar, bar.points, bar.faces, marks, poses, options);
  for (std::size_t t = 0; t < poses.size(); ++t)
    EXPECT_LT(Furthest(fast[t], literal[t]), 1e-10 * BoundingDiagonal(bar.points));
}

TEST(Transfer, StretchReproducesAnyPoseWhenAllIsMarked) {
  const Mesh bar = MakeBar(20);
  PointsX3 pose = bar.points;
  pose.col(0) *= 1.4;
  pose.col(2).array() += 0.2 * pose.col(2).array().square();
  TransferOptions options;
  options.stretch = 1;
  options.volume = options.feet = false;
  options.scale = 1;
  const auto result =
      Transferred(bar, bar.points, bar.faces, AllMarked(bar), {bar.points, pose}, options);
  EXPECT_LT(Furthest(result[1], pose), 1e-9);
  options.stretch = 0;
  EXPECT_GT(
      Furthest(Transferred(bar, bar.points, bar.faces, AllMarked(bar), {pose}, options)[0], pose),
      0.01);
}

TEST(Transfer, VolumeIsKeptUnderAStrongBend) {
  const auto [bar, pose, marks] = MakeBentArm(120 * kDegree);
  const double rest = SignedVolume(bar.points, bar.faces);
  TransferOptions options;
  options.feet = false;
  const auto kept = Transferred(bar, bar.points, bar.faces, marks, {pose}, options);
  options.volume = false;
  const auto lost = Transferred(bar, bar.points, bar.faces, marks, {pose}, options);
  EXPECT_NEAR(SignedVolume(kept[0], bar.faces) / rest, 1, 2e-5);
  EXPECT_LT(SignedVolume(lost[0], bar.faces) / rest, 0.98);
}

TEST(Transfer, TurnedTargetMovesInItsOwnDirections) {
  // The scan faces the other way and is half as large; its motion must be the template's, as seen
  // by itself.
  const Mesh bar = MakeBar();
  Mesh target = bar;
  const Eigen::Matrix3d turn = ExpOf({0, 0, kPi});
  target.points = (0.5 * bar.points * turn.transpose()).rowwise() + Eigen::RowVector3d(5, 0, 0);
  std::vector<Mark> marks = MarksAlong(bar, {0.2, 0.8, 1.4, 1.8});
  marks.push_back(OnBoth(FaceNear(bar, {-0.05, 0, 0.5}), "side"));
  PointsX3 pose = bar.points;
  pose.col(0).array() += 0.3 * pose.col(2).array().square();
  TransferOptions options;
  options.feet = false;
  const auto own = Transferred(bar, bar.points, bar.faces, marks, {pose}, options);
  const auto turned = Transferred(target, bar.points, bar.faces, marks, {pose}, options);
  const PointsX3 expected =
      (0.5 * own[0] * turn.transpose()).rowwise() + Eigen::RowVector3d(5, 0, 0);
  EXPECT_LT(Furthest(turned[0], expected), 1e-9);
  options.align = false;
  EXPECT_THROW(Transferred(target, bar.points, bar.faces, marks, {pose}, options), InputError);
}

TEST(Transfer, PinnedMarkIsHeldExactly) {
  const Mesh bar = MakeBar();
  const std::vector<Mark> marks = MarksAlong(bar, {0.2, 0.8, 1.4, 1.9});
  std::vector<PointsX3> poses;
  for (int t = 0; t < 20; ++t) poses.push_back(Twisted(bar.points, 0, 0.02 * t));
  TransferOptions options;
  options.feet = false;
  options.pins = {{marks[3].name, 6, 10, Eigen::RowVector3d(0.1, 0.05, 1.9)}};
  const auto result = Transferred(bar, bar.points, bar.faces, marks, poses, options);
  for (int t = 6; t <= 10; ++t)
    EXPECT_LT((PositionOf(marks[3].on_target, result[t], bar.faces) - *options.pins[0].at).norm(),
              1e-8);
  // Far from the pin nothing moves, and it is let go smoothly.
  options.pins.clear();
  const auto free = Transferred(bar, bar.points, bar.faces, marks, poses, options);
  EXPECT_LT((result[8].row(0) - free[8].row(0)).norm(), 1e-3);
  EXPECT_LT(Furthest(result[19], free[19]), 1e-12);
  for (int t = 0; t + 1 < 20; ++t) EXPECT_LT(Furthest(result[t], result[t + 1]), 0.05);
  options.pins = {{"nobody", 0, 1, {}}};
  EXPECT_THROW(Transferred(bar, bar.points, bar.faces, marks, poses, options), InputError);
  options.pins = {{marks[0].name, 0, 20, {}}};
  EXPECT_THROW(Transferred(bar, bar.points, bar.faces, marks, poses, options), InputError);
}

TEST(Transfer, PinsAndVolumeAreKeptTogether) {
  const Mesh bar = MakeBar();
  const std::vector<Mark> marks = MarksAlong(bar, {0.2, 0.8, 1.4, 1.9});
  TransferOptions options;
  options.feet = false;
  options.pins = {{marks[3].name, 0, 2, Eigen::RowVector3d(0.25, 0.1, 1.7)}};
  const std::vector<PointsX3> poses(3, Twisted(bar.points, 0, 0.4));
  const auto result = Transferred(bar, bar.points, bar.faces, marks, poses, options);
  EXPECT_LT((PositionOf(marks[3].on_target, result[1], bar.faces) - *options.pins[0].at).norm(),
            1e-12);
  const double rest = SignedVolume(bar.points, bar.faces);
  EXPECT_NEAR(SignedVolume(result[1], bar.faces) / rest, 1, 1e-5);
  options.volume = false;
  const auto without = Transferred(bar, bar.points, bar.faces, marks, poses, options);
  EXPECT_GT(std::abs(SignedVolume(without[1], bar.faces) / rest - 1), 1e-3);
}

TEST(Transfer, OneFrameByItselfIsThatOfTheBatch) {
  const Mesh bar = MakeBar(60);
  const std::vector<Mark> marks = MarksAlong(bar, {0.2, 0.7, 1.4, 1.9});
  std::vector<PointsX3> poses;
  for (int t = 0; t < 6; ++t) poses.push_back(Twisted(bar.points, 0.1 * t, 0.5 * t));
  for (const auto method :
       {TransferMethod::kAuto, TransferMethod::kPaper, TransferMethod::kLiteral})
    for (const double stretch : {0.0, 0.5}) {
      TransferOptions options;
      options.method = method;
      options.stretch = stretch;
      const auto batch = Transferred(bar, bar.points, bar.faces, marks, poses, options);
      Transfer transfer(bar, bar.points, bar.faces, marks, options);
      for (const PointsX3& pose : poses) transfer.Add(pose, "frame");
      for (const int t : {4, 1})
        EXPECT_LT(Furthest(transfer.Frame(t), batch[t]), 1e-11 * BoundingDiagonal(bar.points));
    }
}

TEST(Transfer, SeparatePartsRideOnTheBody) {
  // A body with a button that has no mark of its own.
  Mesh mesh = MakeBar();
  const Mesh button = MakeIcosphere(1);
  const int before = mesh.vertex_count(), faces = mesh.face_count();
  mesh.points.conservativeResize(before + button.vertex_count(), 3);
  mesh.points.bottomRows(button.vertex_count()) =
      (0.02 * button.points).rowwise() + Eigen::RowVector3d(0.08, 0, 1.5);
  mesh.faces.conservativeResize(faces + button.face_count(), 3);
  mesh.faces.bottomRows(button.face_count()) = button.faces.array() + before;
  const Eigen::Matrix3d turn = ExpOf({0.5, 0.3, -1});
  const PointsX3 pose = mesh.points * turn.transpose();
  TransferOptions options;
  options.feet = false;
  options.scale = 1;
  const auto result = Transferred(mesh, mesh.points, mesh.faces, MarksAlong(mesh, {0.3, 0.9, 1.5}),
                                  {pose}, options);
  EXPECT_LT(Furthest(result[0], pose), 1e-9);
}

TEST(Transfer, SameBitsForAnyThreadCount) {
  const Mesh bar = MakeCylinder(0.2, 2, 40, 120);
  const std::vector<Mark> marks = MarksAlong(bar, {0.3, 0.7, 1.3, 1.7});
  std::vector<PointsX3> poses;
  for (int t = 0; t < 7; ++t) poses.push_back(Twisted(bar.points, 0, 0.3 * t));
  SetThreadCount(1);
  const auto one = Transferred(bar, bar.points, bar.faces, marks, poses, {});
  SetThreadCount(3);
  const auto three = Transferred(bar, bar.points, bar.faces, marks, poses, {});
  SetThreadCount(0);
  for (std::size_t t = 0; t < poses.size(); ++t) EXPECT_EQ(one[t], three[t]);
}

TEST(Transfer, UnusableMarksAreNamed) {
  Mesh bar = MakeBar();
  std::vector<Mark> marks = MarksAlong(bar, {0.3, 1.7});
  const auto message = [&](const Mesh& target, const PointsX3& reference) -> std::string {
    try {
      Transfer(target, reference, bar.faces, marks, {});
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  PointsX3 flat = bar.points;
  const int face = marks[1].on_template.face;
  flat.row(bar.faces(face, 1)) = flat.row(bar.faces(face, 0));
  EXPECT_NE(message(bar, flat).find(marks[1].name + "' is on triangle " + std::to_string(face) +
                                    " of the template, which has no area"),
            std::string::npos);
  Mesh flat_target = bar;
  flat_target.points = flat;
  EXPECT_NE(message(flat_target, bar.points).find("of the target, which has no area"),
            std::string::npos);
  Transfer transfer(bar, bar.points, bar.faces, marks, {});
  EXPECT_THROW(transfer.Add(flat, "frame_0003.ply"), InputError);
  marks[0].on_target.face = bar.face_count();
  EXPECT_NE(message(bar, bar.points).find("picked on another mesh"), std::string::npos);
  marks.clear();
  EXPECT_NE(message(bar, bar.points).find("no marks"), std::string::npos);
}

}  // namespace keypose::motion::transfer_test
