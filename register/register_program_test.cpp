// keypose-register: its files and exit codes.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <Eigen/Dense>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/project/landmarks_io.h"
#include "core/io/text/files.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "register/testing/scenes.h"
#include "register/testing/tubes.h"

namespace keypose::registration::register_program_test {

using Eigen::RowVector3d;

class Program : public ::testing::Test, public TestingFolder {
 protected:
  void SetUp() override {
    WriteMesh(folder_ / "source.ply", MakeCylinder(kRadius, kLength, 12, 20));
    target_ = MakeCylinder(kRadius, kLength, 13, 23);
    target_.points = Bent(target_.points, kLength, 1);
    WriteMesh(folder_ / "target.ply", target_);
  }
  int Run(const std::string& arguments) {
    const std::string line = "cd '" + folder_.string() + "' && '" + BinFolder() +
                             "/keypose-register' --target target.ply " + arguments +
                             " > log.txt 2>&1";
    const int status = std::system(line.c_str());
    log_ = ReadFile(folder_ / "log.txt");
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  bool Wrote(const std::string& name) const { return std::filesystem::exists(folder_ / name); }

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

TEST_F(Program, PicksInPhotographsAreNoLandmarksOfAScan) {
  // The pose was one of few photographs, and was picked in them; now it is scanned.
  WriteLandmarks(folder_ / "rest.json", ReadMesh(folder_ / "source.ply"), {{"tip", 3, {1, 0, 0}}});
  WriteFile(folder_ / "wave.json",
            R"({"schema": 2, "pixels": [{"name": "tip", "image": "a.jpg", "pixel": [1, 2]}]})");
  ASSERT_EQ(Run("--source source.ply --landmarks rest.json --landmarks wave.json --registered "
                "with.ply"),
            0)
      << log_;
  EXPECT_NE(log_.find("wave.json holds picks in photographs"), std::string::npos) << log_;
  ASSERT_EQ(Run("--source source.ply --registered without.ply"), 0) << log_;
  EXPECT_EQ(ReadFile(folder_ / "with.ply"), ReadFile(folder_ / "without.ply"));
  EXPECT_EQ(Run("--source source.ply --landmarks wave.json --registered out.ply"), 3) << log_;
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

}  // namespace keypose::registration::register_program_test
