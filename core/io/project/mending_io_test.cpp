#include "core/io/project/mending_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "core/io/text/files.h"
#include "core/surfaces/ray_scene.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::mending_io_test {

using Eigen::Vector3d;
using ::testing::HasSubstr;

/// An egg with a nose, which looks the same from no other side.
Mesh Egg(int levels) {
  Mesh mesh = MakeIcosphere(levels);
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) {
    const Vector3d p = mesh.points.row(v);
    mesh.points.row(v) << p[0] * (1 + 0.3 * std::exp(-8 * (p - Vector3d(1, 0, 0.2)).squaredNorm())),
        0.7 * p[1], 1.4 * p[2] + 0.1 * p[1];
  }
  return mesh;
}

Vector3d PositionOf(const MendStroke::Place& place, const Mesh& mesh) {
  Vector3d at = Vector3d::Zero();
  for (int k = 0; k < 3; ++k)
    at += place.barycentric[k] * mesh.points.row(mesh.faces(place.face, k)).transpose();
  return at;
}

class MendingIo : public ::testing::Test, public TestingFolder {
 protected:
  MendingIo() : egg_(Egg(4)), file_(folder_ / "rest.json") {
    stroke_ = {MendTool::kPull, 0.2, -0.5, {{7, {0.25, 0.5, 0.25}}, {900, {1, 0, 0}}}};
    fill_ = {MendTool::kFill, 0.1, 1, {{300, {0.2, 0.2, 0.6}}}};
  }
  std::string Fault(const std::string& text) {
    WriteFile(file_, text);
    try {
      RequireOnMesh(ReadMendStrokes(file_, egg_, nullptr), file_);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  Mesh egg_;
  std::filesystem::path file_;
  MendStroke stroke_, fill_;
};

TEST_F(MendingIo, ComeBackAsTheyWereWritten) {
  WriteFile(file_, MendStrokesText(egg_, {stroke_, fill_}));
  CarryLog log;
  const MendStrokes read = ReadMendStrokes(file_, egg_, &log);
  ASSERT_EQ(read.strokes.size(), 2u);
  EXPECT_EQ(read.strokes[0].tool, MendTool::kPull);
  EXPECT_EQ(read.strokes[0].radius, 0.2);
  EXPECT_EQ(read.strokes[0].strength, -0.5);
  ASSERT_EQ(read.strokes[0].places.size(), 2u);
  EXPECT_EQ(read.strokes[0].places[0].face, 7);
  EXPECT_EQ(read.strokes[0].places[0].barycentric, stroke_.places[0].barycentric);
  EXPECT_EQ(read.strokes[1].tool, MendTool::kFill);
  EXPECT_NO_THROW(RequireOnMesh(read, file_));
  EXPECT_TRUE(log.notes.empty() && log.warnings.empty());
}

TEST_F(MendingIo, FollowToAMeshThatWasRebuiltTurnedAndLarger) {
  WriteFile(file_, MendStrokesText(egg_, {stroke_, fill_}));
  Mesh now = Egg(5);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.4, Vector3d::UnitZ()).toRotationMatrix();
  now.points = 2 * now.points * turn.transpose();
  CarryLog log;
  const MendStrokes read = ReadMendStrokes(file_, now, &log);
  EXPECT_NO_THROW(RequireOnMesh(read, file_));
  EXPECT_NEAR(read.strokes[0].radius, 0.4, 0.004);
  const Vector3d wanted = 2 * turn * PositionOf(stroke_.places[0], egg_);
  EXPECT_LT((PositionOf(read.strokes[0].places[0], now) - wanted).norm(), 0.03);
  ASSERT_EQ(log.notes.size() + log.warnings.size(), 1u);
}

TEST_F(MendingIo, StrokesOnWhatIsGoneAreNamed) {
  Mesh horned = egg_;
  const Vector3d tip = horned.points.row(horned.faces(300, 2));
  for (Eigen::Index v = 0; v < horned.points.rows(); ++v) {
    const double away = (horned.points.row(v).transpose() - tip).norm() / 0.25;
    if (away < 1) horned.points.row(v) += 0.9 * (1 - away) * tip.transpose().normalized();
  }
  fill_.places[0].barycentric = {0, 0, 1};
  WriteFile(file_, MendStrokesText(horned, {stroke_, fill_}));
  const MendStrokes read = ReadMendStrokes(file_, egg_, nullptr);
  EXPECT_EQ(read.faults[0], "");
  EXPECT_NE(read.faults[1], "");
  try {
    RequireOnMesh(read, file_);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("1 of 2 strokes do not lie on the mesh any more (stroke 2 "
                                        "(fill): "));
  }
}

TEST_F(MendingIo, PlacesByHandAreTheNearestPoints) {
  WriteFile(file_, R"({"strokes": [{"tool": "smooth", "radius": 0.2, "places": [[0, 0.72, 0]]}]})");
  const MendStrokes read = ReadMendStrokes(file_, egg_, nullptr);
  ASSERT_EQ(read.strokes.size(), 1u);
  EXPECT_EQ(read.strokes[0].strength, 1);
  EXPECT_LT((PositionOf(read.strokes[0].places[0], egg_) - Vector3d(0, 0.7, 0)).norm(), 0.03);
}

TEST_F(MendingIo, WhatIsWrongIsSaidByTheStroke) {
  const auto with = [](const std::string& fields) { return "{\"strokes\": [{" + fields + "}]}"; };
  const std::string radius = R"("radius": 0.1, "places": [[0, 0.7, 0]])";
  EXPECT_EQ(Fault(with(R"("tool": "fill", )" + radius)), "");
  EXPECT_THAT(Fault(with(R"("tool": "cut", )" + radius)), HasSubstr("stroke 1 has the tool 'cut'"));
  EXPECT_THAT(Fault(with(R"("tool": "fill", "strength": -1, )" + radius)),
              HasSubstr("stroke 1 needs a strength from 0 to 1"));
  EXPECT_THAT(Fault(with(R"("tool": "fill", "radius": 0, "places": [[0, 0.7, 0]])")),
              HasSubstr("stroke 1 needs a radius above 0"));
  EXPECT_THAT(Fault(with(R"("tool": "fill", "radius": 0.1, "places": [])")),
              HasSubstr("stroke 1 has no place"));
  EXPECT_THAT(Fault(with(R"("tool": "fill", "radius": 0.1, "places": [[0, 3, 0]])")),
              HasSubstr("stroke 1 (fill): a place is 2.3 off the mesh"));
  EXPECT_THAT(Fault(with(R"("tool": "fill", "radius": 0.1, "places": [{"face": 3}])")),
              HasSubstr("the file does not say which mesh its faces are of"));
  EXPECT_THAT(Fault("{}"), HasSubstr("is not a file of strokes"));
  EXPECT_THAT(Fault("[1"), HasSubstr("is not a file of strokes"));
}

}  // namespace keypose::mending_io_test
