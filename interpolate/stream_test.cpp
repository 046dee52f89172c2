// The program: its output, constant memory for long animations, and no partial output.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/io/meshes/mesh_io.h"
#include "core/io/text/files.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"

namespace keypose::stream_test {

namespace fs = std::filesystem;

class InterpolateProgram : public ::testing::Test, public TestingFolder {
 protected:
  void SetUp() override {
    mesh_ = MakeCylinder(0.12, 2, 30, 59);  // 3,600 faces
    Write("a.ply", 0), Write("b.ply", 1.5), Write("c.ply", 2.6);
  }

  void Write(const std::string& name, double angle) const {
    Mesh bent = mesh_;
    for (Eigen::Index i = 0; i < bent.points.rows() && angle > 0; ++i) {
      const double radius = 2 / angle, a = mesh_.points(i, 2) / radius,
                   r = radius - mesh_.points(i, 0);
      bent.points.row(i) << radius - r * std::cos(a), mesh_.points(i, 1), r * std::sin(a);
    }
    WriteMesh(folder_ / name, bent);
  }

  std::string Command(const std::string& arguments) const {
    return "cd '" + folder_.string() + "' && '" + BinFolder() + "/keypose-interpolate' " +
           arguments + " > log.txt 2>&1";
  }
  int Run(const std::string& arguments, const std::string& before = "") const {
    return WEXITSTATUS(std::system((before + Command(arguments)).c_str()));
  }
  nlohmann::json Json(const std::string& name) const {
    return nlohmann::json::parse(ReadFile(folder_ / name));
  }
  int Files() const {
    return static_cast<int>(
        std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  Mesh mesh_;
};

TEST_F(InterpolateProgram, WritesFramesAndWhatTheyDoToAreaAndVolume) {
  std::ofstream(folder_ / "timeline.json")
      << R"({"schema":2,"fps":12,"step":2,"keys":[{"pose":"a","time":0},{"pose":"b","time":1,"hold":0.5},
      {"pose":"c","time":2.5,"ease":"in-out"}]})";
  ASSERT_EQ(Run("--keys a.ply --keys b.ply --keys c.ply --timeline timeline.json --frames frames "
                "--report report.json"),
            0)
      << ReadFile(folder_ / "log.txt");
  const nlohmann::json json = Json("frames/distortion.json");
  ASSERT_EQ(json["frames"].size(), 31u);
  EXPECT_EQ(json["schema"], 2);
  EXPECT_EQ(json["key_frames"], (std::vector<int>{0, 12, 30}));
  for (const auto& frame : json["frames"]) {
    for (const char* field : {"t", "time", "area", "volume", "linear_area", "linear_volume",
                              "area_path", "area_deviation"})
      EXPECT_TRUE(frame[field].is_number()) << field;
    EXPECT_LT(std::abs(frame["volume_deviation"].get<double>()), 1e-8);
  }
  EXPECT_EQ(ReadFile(folder_ / "frames/frame_0012.ply"), ReadFile(folder_ / "b.ply"));
  EXPECT_EQ(ReadFile(folder_ / "frames/frame_0018.ply"), ReadFile(folder_ / "b.ply"));  // held
  EXPECT_EQ(ReadFile(folder_ / "frames/frame_0021.ply"),
            ReadFile(folder_ / "frames/frame_0020.ply"));
  EXPECT_EQ(json["frames"][21]["same_as"], 20);
  // The measurements are of the written frames.
  const Mesh frame = ReadMesh(folder_ / "frames/frame_0006.ply");
  EXPECT_NEAR(json["frames"][6]["area"],
              SurfaceArea(frame.points, frame.faces) / SurfaceArea(mesh_.points, mesh_.faces),
              1e-12);
  const nlohmann::json measured = Json("report.json")["measurements"];
  EXPECT_EQ(measured["frames"], 31);
  EXPECT_EQ(measured["keys"], 3);
  EXPECT_LT(measured["volume_path_deviation"], 1e-8);
}

TEST_F(InterpolateProgram, InBetweensThatATimelineOverrulesAreToldOf) {
  std::ofstream(folder_ / "timed.json")
      << R"({"fps":12,"keys":[{"pose":"a","time":0},{"pose":"b","time":0.25}]})";
  std::ofstream(folder_ / "order.json") << R"({"fps":12,"loop":false,"keys":[{"hold":0.5},{}]})";
  const auto frames = [&](const std::string& more) {
    EXPECT_EQ(Run("--keys a.ply --keys b.ply --method linear --overwrite --frames f "
                  "--report r.json --timeline " +
                  more),
              0)
        << ReadFile(folder_ / "log.txt");
    return Json("f/distortion.json")["frames"].size();
  };
  EXPECT_EQ(frames("timed.json --steps 5"), 4u);
  EXPECT_NE(Json("r.json")["warnings"].dump().find("steps 5 has no effect"), std::string::npos);
  EXPECT_EQ(frames("timed.json"), 4u);
  EXPECT_TRUE(Json("r.json")["warnings"].empty());
  EXPECT_EQ(frames("order.json --steps 5"), 13u) << "six stand, five between";
  EXPECT_TRUE(Json("r.json")["warnings"].empty());
}

TEST_F(InterpolateProgram, MemoryDoesNotGrowWithTheNumberOfFrames) {
#if defined(KEYPOSE_SANITIZED)
  GTEST_SKIP() << "sanitizers keep memory of their own: peaks say nothing";
#endif
  const auto peak = [&](int steps) {
    const std::string name = std::to_string(steps);
    EXPECT_EQ(Run("--keys a.ply --keys b.ply --keys c.ply --steps " + name + " --frames f" + name +
                  " --report r" + name + ".json"),
              0);
    fs::remove_all(folder_ / ("f" + name));
    return Json("r" + name + ".json")["peak_bytes"].get<double>();
  };
  const double few = peak(24), many = peak(499);
  // 950 more frames would need 40 MB; only a few numbers per frame are kept.
  EXPECT_LT(many - few, 4e6);
}

TEST_F(InterpolateProgram, AFullDiskLeavesNothingBehind) {
  const int files = Files() + 1;  // the log
  // Files may not grow beyond 100 kB: the first frame does not fit.
  EXPECT_EQ(Run("--keys a.ply --keys b.ply --frames frames", "trap '' XFSZ; ulimit -f 100; "), 4)
      << ReadFile(folder_ / "log.txt");
  EXPECT_FALSE(fs::exists(folder_ / "frames"));
  EXPECT_EQ(Files(), files);
}

TEST_F(InterpolateProgram, AnInterruptLeavesNothingBehind) {
  const int files = Files() + 1;
  const pid_t child = ::fork();
  if (child == 0) {
    const std::string command = "exec '" + BinFolder() +
                                "/keypose-interpolate' --keys a.ply --keys b.ply --steps 50000 "
                                "--frames frames > log.txt 2>&1";
    if (::chdir(folder_.c_str()) != 0) ::_exit(1);
    ::execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
    ::_exit(1);
  }
  // When the first frames exist, it is running.
  const auto writing = [&] {
    for (const auto& entry :
         fs::recursive_directory_iterator(folder_, fs::directory_options::skip_permission_denied))
      if (entry.path().filename().string().starts_with("frame_0")) return true;
    return false;
  };
  for (int k = 0; k < 2000 && !writing(); ++k) ::usleep(10000);
  ::kill(child, SIGINT);
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 130);
  EXPECT_FALSE(fs::exists(folder_ / "frames"));
  EXPECT_EQ(Files(), files);
}

/// A prism of quads above and below whose corner 1 lies at the given place.
std::string PrismWithCornerAt(const std::string& place) {
  std::string obj;
  for (const char* z : {" 0", " 1"})
    for (const std::string& corner :
         {std::string("0 0"), place, std::string("1 1"), std::string("0 1")})
      obj += "v " + corner + z + "\n";
  return obj + "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
}

TEST_F(InterpolateProgram, KeysWhosePolygonsAreCutApartInOtherWaysServe) {
  WriteFile(folder_ / "flat.obj", PrismWithCornerAt("1 0"));
  WriteFile(folder_ / "bent.obj", PrismWithCornerAt("0.25 0.75"));
  const Mesh flat = ReadMesh(folder_ / "flat.obj"), bent = ReadMesh(folder_ / "bent.obj");
  WriteMesh(folder_ / "flat.ply", flat);
  ASSERT_NE(bent.faces, flat.faces);
  const auto expect = [this](const std::string& a, const std::string& b, const Mesh& first,
                             const Mesh& last) {
    ASSERT_EQ(Run("--keys " + a + " --keys " + b + " --steps 1 --frames frames --overwrite"), 0)
        << ReadFile(folder_ / "log.txt");
    const Mesh shown = ReadMesh(folder_ / "frames/frame_0002.ply");
    EXPECT_EQ(shown.faces, first.faces);
    EXPECT_EQ(shown.points, last.points);
  };
  expect("flat.obj", "bent.obj", flat, bent);
  expect("bent.obj", "flat.obj", bent, flat);
  expect("flat.ply", "bent.obj", flat, bent);
}

TEST_F(InterpolateProgram, ATimelineThatIsWrongIsRefusedByName) {
  std::ofstream(folder_ / "t.json")
      << R"({"schema":2,"fps":12,"keys":[{"pose":"a","time":0},{"pose":"b","time":1,"eas":"in"}]})";
  EXPECT_EQ(Run("--keys a.ply --keys b.ply --timeline t.json --frames frames"), 3);
  EXPECT_NE(ReadFile(folder_ / "log.txt")
                .find("t.json: key 1 ('b') has no field 'eas'; did you mean 'ease'?"),
            std::string::npos);
  std::ofstream(folder_ / "t.json") << R"({"fps":12,"table":0,"keys":[{"time":0},{"time":1}]})";
  EXPECT_EQ(Run("--keys a.ply --keys b.ply --timeline t.json --frames frames --method linear"), 2);
}

}  // namespace keypose::stream_test
