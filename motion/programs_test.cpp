// The programs keypose-animate and keypose-transfer, as a user starts them.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/frame_folder.h"
#include "core/io/project/landmarks_io.h"
#include "core/io/testing/other_cut.h"
#include "core/io/text/files.h"
#include "core/numbers/rotations.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/testing/cut_in_charts.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "core/values/angles.h"
#include "core/values/size_of.h"
#include "deform/levels/geodesics.h"
#include "motion/root/feet.h"
#include "motion/testing/rigged_scan.h"
#include "motion/transfer.h"

namespace keypose::motion::programs_test {

namespace fs = std::filesystem;

class Programs : public ::testing::Test, public TestingFolder {
 protected:
  int Run(const std::string& program, const std::string& arguments) {
    const std::string command = "cd '" + folder_.string() + "' && '" + BinFolder() + "/keypose-" +
                                program + "' " + arguments + " > log.txt 2>&1";
    const int status = std::system(command.c_str());
    log_ = ReadFile(folder_ / "log.txt");
    return WEXITSTATUS(status);
  }
  bool Says(const std::string& words) const { return log_.find(words) != std::string::npos; }

  /// A bar that bends, another bar of other faces, and marks on both.
  void WriteBars() {
    const Mesh small = MakeCylinder(0.1, 2, 10, 30);
    fs::create_directory(folder_ / "template");
    for (int t = 0; t < 4; ++t) {
      Mesh frame = small;
      frame.points.col(0).array() += 0.1 * t * frame.points.col(2).array().square();
      WriteMesh(folder_ / "template" / FrameFileName(t), frame);
    }
    WriteFile(folder_ / "template/distortion.json", FrameNotesText({{}, {}, {}, {}}, 12, "test"));
    target_ = MakeCylinder(0.15, 1.6, 16, 40);
    WriteMesh(folder_ / "target.ply", target_);
    std::vector<LandmarkPair> pairs;
    for (int k = 0; k < 12; ++k) {
      const double share = (k + 0.5) / 12, side = k % 2 ? 1 : -1;
      LandmarkPair pair;
      pair.name = "m" + std::to_string(k);
      pair.source = {pair.name, FaceNear(small, {0.1 * side, 0, 2 * share}), {0.2, 0.3, 0.5}};
      pair.target = {pair.name, FaceNear(target_, {0.15 * side, 0, 1.6 * share}), {0.2, 0.3, 0.5}};
      pairs.push_back(pair);
    }
    WriteLandmarkPairs(folder_ / "marks.json", small, target_, pairs);
  }

  static constexpr const char* kTransfer =
      "--template template --target target.ply --marks marks.json --frames out --overwrite ";

  std::string log_;
  Mesh target_;
};

TEST_F(Programs, TransferWritesFramesThatExportTakes) {
  WriteBars();
  ASSERT_EQ(Run("transfer", std::string(kTransfer) + "--report report.json"), 0) << log_;
  const std::vector<fs::path> frames = NumberedFrames(folder_ / "out", "test");
  ASSERT_EQ(frames.size(), 4u);
  EXPECT_EQ(ReadMesh(frames[3]).faces, target_.faces);
  EXPECT_EQ(FrameRateOf(folder_ / "out"), 12);
  const auto notes = nlohmann::json::parse(ReadFile(folder_ / "out/distortion.json"));
  ASSERT_EQ(notes["frames"].size(), 4u);
  EXPECT_NEAR(notes["frames"][3]["volume"].get<double>(), 1, 1e-4);
  const auto report = nlohmann::json::parse(ReadFile(folder_ / "report.json"));
  EXPECT_EQ(report["measurements"]["marks"], 12);
  EXPECT_LT(report["measurements"]["volume_deviation"].get<double>(), 1e-4);
}

TEST_F(Programs, ATargetThatIsCutForItsTextureMovesAsTheWholeOne) {
  WriteBars();
  ASSERT_EQ(Run("transfer", kTransfer), 0) << log_;
  const Mesh whole = ReadMesh(folder_ / "out/frame_0003.ply");
  std::vector<int> origin;
  const Mesh cut = CutInCharts(target_, 0.8, &origin);
  ASSERT_GT(SizeOf(origin), target_.vertex_count());
  WriteMesh(folder_ / "target.ply", cut);
  std::vector<LandmarkPair> pairs = ReadLandmarkPairs(
      {folder_ / "marks.json"}, ReadMesh(folder_ / "template/frame_0000.ply"), target_);
  WriteLandmarkPairs(folder_ / "marks.json", ReadMesh(folder_ / "template/frame_0000.ply"), cut,
                     pairs);
  ASSERT_EQ(Run("transfer", kTransfer), 0) << log_;
  const Mesh moved = ReadMesh(folder_ / "out/frame_0003.ply");
  EXPECT_EQ(moved.faces, cut.faces);
  EXPECT_LT((moved.points - whole.points(origin, Eigen::all)).cwiseAbs().maxCoeff(), 1e-5);
}

TEST_F(Programs, TransferInTheTemplatesSpaceLiesOverTheTemplate) {
  WriteBars();
  // The same bar as the template's, but larger, turned about z and elsewhere.
  const Mesh small = ReadMesh(folder_ / "template/frame_0000.ply");
  target_ = small;
  target_.points = 3 * small.points * ExpOf({0, 0, 2}).transpose();
  target_.points.rowwise() += Eigen::RowVector3d(5, -7, 0);
  std::vector<LandmarkPair> pairs;
  for (int k = 0; k < 24; ++k) {
    const double angle = 2.4 * k;
    LandmarkPair pair;
    pair.name = "m" + std::to_string(k);
    const int face =
        FaceNear(small, {0.1 * std::cos(angle), 0.1 * std::sin(angle), 2 * (k + 0.5) / 24});
    pair.source = pair.target = {pair.name, face, {0.2, 0.3, 0.5}};
    pairs.push_back(pair);
  }
  WriteMesh(folder_ / "target.ply", target_);
  WriteLandmarkPairs(folder_ / "marks.json", small, target_, pairs);
  ASSERT_EQ(Run("transfer", std::string(kTransfer) + "--space template --feet false"), 0) << log_;
  for (const int f : {0, 3}) {
    const Mesh made = ReadMesh(folder_ / "out" / FrameFileName(f)),
               wanted = ReadMesh(folder_ / "template" / FrameFileName(f));
    // The template bends; its place and size must be met, its shape nearly.
    EXPECT_LT((made.points - wanted.points).rowwise().norm().maxCoeff(), f == 0 ? 1e-3 : 0.08) << f;
  }
}

TEST_F(Programs, TransferNamesWhatIsWrong) {
  WriteBars();
  WriteMesh(folder_ / "other.ply", MakeIcosphere(3));
  EXPECT_EQ(Run("transfer", "--template template --target other.ply --marks marks.json --frames x"),
            3);
  EXPECT_TRUE(Says("marks.json")) << log_;
  EXPECT_EQ(Run("transfer", std::string(kTransfer) + "--reference other.ply"), 3) << log_;

  WriteFile(folder_ / "pins.json", R"({"pins": [{"mark": "paw", "from": 0, "to": 1}]})");
  EXPECT_EQ(Run("transfer", std::string(kTransfer) + "--pins pins.json"), 3);
  EXPECT_TRUE(Says("'paw'")) << log_;
  for (const char* pins : {"[]", R"({"pins": [{"mark": "m1", "from": 0.5, "to": 1}]})",
                           R"({"pins": [{"mark": "m1", "from": 0, "to": 1, "at": [0, 1]}]})",
                           R"({"pins": [3]})", R"({"pins": [{"mark": "m1", "from": 2, "to": 1}]})",
                           R"({"pins": [{"mark": "m1", "from": 0, "to": 99}]})"}) {
    WriteFile(folder_ / "pins.json", pins);
    EXPECT_EQ(Run("transfer", std::string(kTransfer) + "--pins pins.json"), 3) << pins << log_;
  }
  WriteFile(folder_ / "pins.json", R"({"pins": [{"mark": "m1", "from": 0, "to": 1}]})");
  EXPECT_EQ(Run("transfer", std::string(kTransfer) + "--pins pins.json --method paper"), 2);
  EXPECT_EQ(Run("transfer", std::string(kTransfer) + "--pins pins.json"), 0) << log_;

  WriteMesh(folder_ / "template/frame_0002.ply", MakeIcosphere(2));
  EXPECT_EQ(Run("transfer", kTransfer), 3);
  EXPECT_TRUE(Says("frame_0002.ply of the template does not have the faces")) << log_;
}

TEST_F(Programs, MeshThatFacesTheOtherWayMovesRightOrIsRefused) {
  WriteBars();
  Mesh turned = target_;
  turned.points = target_.points * ExpOf({0, 0, kPi}).transpose();
  std::vector<LandmarkPair> pairs = ReadLandmarkPairs(
      {folder_ / "marks.json"}, ReadMesh(folder_ / "template/frame_0000.ply"), target_);
  WriteLandmarkPairs(folder_ / "marks.json", ReadMesh(folder_ / "template/frame_0000.ply"), turned,
                     pairs);
  WriteMesh(folder_ / "target.ply", turned);
  ASSERT_EQ(Run("transfer", kTransfer), 0) << log_;
  EXPECT_TRUE(Says("turned by")) << log_;
  const Mesh last = ReadMesh(folder_ / "out/frame_0003.ply");
  Eigen::Index top = 0;
  turned.points.col(2).maxCoeff(&top);
  EXPECT_LT(last.points(top, 0), -0.2);  // the template bends towards +x, which it sees as -x
  EXPECT_EQ(Run("transfer", std::string(kTransfer) + "--align none"), 3);
  EXPECT_TRUE(Says("opposite ways")) << log_;
}

TEST_F(Programs, MarksOfAnotherPoseOfTheTemplateHoldByTheirTriangles) {
  WriteBars();
  const fs::path template_folder = folder_ / "template";
  const Mesh straight = ReadMesh(template_folder / "frame_0000.ply");
  std::vector<LandmarkPair> pairs = ReadLandmarkPairs({folder_ / "marks.json"}, straight, target_);
  WriteMesh(folder_ / "reference.ply", straight);
  ASSERT_EQ(Run("transfer", std::string(kTransfer) + "--reference reference.ply"), 0) << log_;
  EXPECT_FALSE(Says("another pose")) << log_;
  // Suggestions on the straight bar, and a template that begins bent.
  for (LandmarkPair& pair : pairs) pair.confirmed = false;
  WriteLandmarkPairs(folder_ / "marks.json", straight, target_, pairs);
  fs::rename(template_folder / "frame_0003.ply", template_folder / "frame_0000.ply");
  ASSERT_EQ(Run("transfer", std::string(kTransfer) + "--report report.json"), 0) << log_;
  EXPECT_TRUE(Says("another pose than its first frame") && Says("as --reference")) << log_;
  const auto report = nlohmann::json::parse(ReadFile(folder_ / "report.json"));
  EXPECT_EQ(report["measurements"]["marks"], 12);
  // Suggestions on another mesh are lost, and the message does not say that there were none.
  WriteLandmarkPairs(folder_ / "marks.json", MakeIcosphere(3), target_, pairs);
  EXPECT_EQ(Run("transfer", kTransfer), 3);
  EXPECT_TRUE(Says("12 unconfirmed suggestions could not follow")) << log_;
}

TEST_F(Programs, AReferenceWhosePolygonsAreCutAnotherWayServes) {
  WriteBars();
  const Mesh straight = ReadMesh(folder_ / "template/frame_0000.ply");
  const std::vector<LandmarkPair> pairs =
      ReadLandmarkPairs({folder_ / "marks.json"}, straight, target_);
  ASSERT_EQ(Run("transfer", kTransfer), 0) << log_;
  const Mesh wanted = ReadMesh(folder_ / "out/frame_0003.ply");
  WriteWithOtherCut(folder_ / "reference.obj", straight);
  const Mesh reference = ReadMesh(folder_ / "reference.obj");
  ASSERT_EQ((reference.faces - straight.faces).rowwise().any().count(), 2);
  WriteLandmarkPairs(folder_ / "marks.json", reference, target_, pairs);
  ASSERT_EQ(Run("transfer", std::string(kTransfer) + "--reference reference.obj"), 0) << log_;
  const Mesh made = ReadMesh(folder_ / "out/frame_0003.ply");
  EXPECT_LT((made.points - wanted.points).rowwise().norm().maxCoeff(), 1e-3);
}

TEST_F(Programs, TransferWarnsOfATargetThatLiesAndOfAnotherRate) {
  WriteBars();
  ASSERT_EQ(Run("transfer", kTransfer), 0) << log_;
  EXPECT_FALSE(Says("leans") || Says("as fast")) << log_;
  ASSERT_EQ(Run("transfer", std::string(kTransfer) + "--fps 24"), 0) << log_;
  EXPECT_TRUE(Says("goes 2 times as fast")) << log_;
  // The same bar from a program that has y up: z becomes y.
  const Mesh small = ReadMesh(folder_ / "template/frame_0000.ply");
  Mesh lying = target_;
  lying.points.col(1) = target_.points.col(2), lying.points.col(2) = -target_.points.col(1);
  const std::vector<LandmarkPair> pairs =
      ReadLandmarkPairs({folder_ / "marks.json"}, small, target_);
  WriteMesh(folder_ / "target.ply", lying);
  WriteLandmarkPairs(folder_ / "marks.json", small, lying, pairs);
  ASSERT_EQ(Run("transfer", kTransfer), 0) << log_;
  EXPECT_TRUE(Says("the target leans by 90 degrees")) << log_;
}

TEST_F(Programs, AnimateListsJointsThatItDoesNotKnow) {
  WriteFile(folder_ / "clip.bvh",
            "HIERARCHY\nROOT Boing\n{\n OFFSET 0 0 0\n CHANNELS 3 Xrotation Yrotation Zrotation\n"
            " JOINT Boom\n {\n  OFFSET 0 1 0\n  CHANNELS 3 Xrotation Yrotation Zrotation\n"
            "  End Site\n  {\n   OFFSET 0 1 0\n  }\n }\n}\n"
            "MOTION\nFrames: 2\nFrame Time: 0.04\n0 0 0 0 0 0\n0 0 90 0 0 0\n");
  WriteMesh(folder_ / "body.obj", MakeBox(1, 1, 1));
  WriteFile(folder_ / "bones.tgf", "1 0 0 0\n2 0 1 0\n#\n1 2\n#\n");
  WriteFile(folder_ / "weights.dmat", "1 8\n1\n1\n1\n1\n1\n1\n1\n1\n");
  const std::string rig =
      "--clip clip.bvh --mesh body.obj --skeleton bones.tgf --weights weights.dmat --frames out ";
  EXPECT_EQ(Run("animate", rig), 3);
  EXPECT_TRUE(Says("Boing, Boom") && Says("1-2") && Says("--joints")) << log_;
  WriteFile(folder_ / "joints.json", R"({"joints": {"Bang": "1-2"}})");
  EXPECT_EQ(Run("animate", rig + "--joints joints.json"), 3);
  EXPECT_TRUE(Says("no joint 'Bang'")) << log_;
  WriteFile(folder_ / "joints.json", R"({"joints": {"Boing": "1-2"}})");
  ASSERT_EQ(Run("animate", rig + "--joints joints.json --fps 25"), 0) << log_;
  // The box is turned by 90 degrees about z, then y becomes up.
  const Mesh frame = ReadMesh(folder_ / "out/frame_0001.ply");
  EXPECT_NEAR(frame.points.col(0).minCoeff(), -1, 1e-9);
  EXPECT_NEAR(frame.points.col(2).minCoeff(), 0, 1e-9);
}

/// A clip of legs and one arm at 25 frames a second: a T pose in front, then bent knees.
std::string ClipOfLegsText() {
  const char* turns = "  CHANNELS 3 Zrotation Yrotation Xrotation\n";
  std::string text =
      "HIERARCHY\nROOT Hips\n{\n OFFSET 0 0 0\n CHANNELS 6 Xposition Yposition Zposition Zrotation "
      "Yrotation Xrotation\n";
  const auto joint = [&](const std::string& name, const char* offset) {
    text += " JOINT " + name + "\n {\n  OFFSET " + offset + "\n" + turns;
  };
  joint("LeftArm", "0.2 0 0.5"), joint("LeftForeArm", "0.3 0 0"), text += " }\n }\n";
  for (const char* side : {"Left", "Right"}) {
    joint(std::string(side) + "UpLeg", side[0] == 'L' ? "0.1 0 0" : "-0.1 0 0");
    joint(std::string(side) + "Leg", "0 0 -0.4"), text += " }\n }\n";
  }
  text += "}\nMOTION\nFrames: 3\nFrame Time: 0.04\n";
  for (const char* bend : {" 0", " 70", " 75"}) {
    text += "0 0 0 0 0 0";
    for (int k = 0; k < 6 * 3; ++k) text += bend;
    text += "\n";
  }
  return text;
}

TEST_F(Programs, AnimateWarnsOfWhatAClipLacks) {
  WriteFile(folder_ / "clip.bvh", ClipOfLegsText());
  const Mesh ball = MakeIcosphere(2);
  WriteMesh(folder_ / "body.obj", ball);
  Eigen::Index top = 0, bottom = 0, left = 0, right = 0;
  ball.points.col(1).maxCoeff(&top), ball.points.col(1).minCoeff(&bottom);
  ball.points.col(0).maxCoeff(&left), ball.points.col(0).minCoeff(&right);
  nlohmann::json rig = {
      {"joints",
       {{"t", {top}}, {"b", {bottom}}, {"l", {left}}, {"r", {right}}, {"m", {top, bottom}}}},
      {"bones", {{"root", {{"head", "m"}, {"tail", "t"}, {"parent", nullptr}}}}}};
  const auto add = [&](const std::string& bone, const char* head, const std::string& parent) {
    rig["bones"][bone] = {{"head", head}, {"tail", "b"}, {"parent", parent}};
  };
  for (const auto& [side, head] : {std::pair(".L", "l"), std::pair(".R", "r")}) {
    add(std::string("upperleg01") + side, head, "root");
    add(std::string("lowerleg01") + side, "b", std::string("upperleg01") + side);
    add(std::string("upperarm01") + side, head, "root");
    add(std::string("lowerarm01") + side, head, std::string("upperarm01") + side);
  }
  WriteFile(folder_ / "rig.mhskel", rig.dump());
  WriteFile(folder_ / "rig.mhw", R"({"weights": {"root": [[0, 1]]}})");
  const std::string command =
      "--clip clip.bvh --mesh body.obj --skeleton rig.mhskel --weights rig.mhw --frames out "
      "--overwrite ";
  ASSERT_EQ(Run("animate", command), 0) << log_;
  EXPECT_TRUE(Says("no joint of the clip moves the bones upperarm01.R, lowerarm01.R")) << log_;
  EXPECT_TRUE(Says("leave it out with --from 0.0400")) << log_;
  EXPECT_FALSE(Says("`up`")) << log_;
  // The clip has z up and the rig y, which only auto can tell apart.
  ASSERT_EQ(Run("animate", command + "--from 0.04 --up y"), 0) << log_;
  EXPECT_FALSE(Says("rest pose")) << log_;
  EXPECT_TRUE(Says("z is up in the clip and y in the rig")) << log_;
}

/// A walk of the library on MakeHuman's body, and the same body with shorter legs as the target.
class LibraryWalk : public Programs {
 protected:
  bool Prepare() {
    const fs::path motion = DataFolder() / "motion";
    if (!fs::exists(motion)) return false;
    const fs::path human = motion / "human/makehuman";
    EXPECT_EQ(Run("animate", "--clip '" + (motion / "bvh/131_01.bvh").string() + "' --mesh '" +
                                 (human / "base.obj").string() + "' --skeleton '" +
                                 (human / "rigs/default.mhskel").string() + "' --weights '" +
                                 (human / "rigs/default_weights.mhw").string() +
                                 "' --frames walk --reference body.ply --to 3"),
              0)
        << log_;
    body_ = ReadMesh(folder_ / "body.ply");
    for (const fs::path& path : NumberedFrames(folder_ / "walk", "test"))
      frames_.push_back(ReadMesh(path).points);
    target_ = body_;
    const double hips = 0.5 * body_.points.col(2).maxCoeff();
    for (Eigen::Index i = 0; i < target_.points.rows(); ++i) {
      double& z = target_.points(i, 2);
      z = z < hips ? 0.6 * z : z - 0.4 * hips;
    }
    const GeodesicGraph graph(body_.points, body_.faces, GeodesicGraph::kEdgesOnly);
    std::vector<int> face_of(body_.points.rows(), -1);
    const Eigen::VectorXd areas = FaceAreas(body_.points, body_.faces);
    for (int f = 0; f < body_.face_count(); ++f)
      for (int k = 0; k < 3; ++k) {
        int& best = face_of[body_.faces(f, k)];
        if (best < 0 || areas[f] > areas[best]) best = f;
      }
    for (int v : graph.FarthestPoints(60)) {
      Mark mark;
      mark.name = std::to_string(v);
      mark.on_template.face = mark.on_target.face = face_of[v];
      marks_.push_back(mark);
    }
    return true;
  }

  std::vector<PointsX3> Transferred(bool feet) const {
    TransferOptions options;
    options.feet = feet;
    Transfer transfer(target_, body_.points, body_.faces, marks_, options);
    for (const PointsX3& frame : frames_) transfer.Add(frame, "frame");
    std::vector<PointsX3> result;
    transfer.Run([&](int, const PointsX3& points) { result.push_back(points); });
    return result;
  }

  /// Mean way of the patches that stand, from frame to frame, over the height.
  double SlideOf(const std::vector<PointsX3>& poses) const {
    const double height = body_.points.col(2).maxCoeff();
    double sum = 0;
    int count = 0;
    for (const SolePatch& sole : FindSoles(body_.points, body_.faces)) {
      SoleTrack track{PointsX3(std::ssize(frames_), 3), Eigen::VectorXd(std::ssize(frames_))};
      PointsX3 moved(std::ssize(frames_), 3);
      for (int t = 0; t < SizeOf(frames_); ++t) {
        track.centres.row(t).setZero();
        track.lowest[t] = 1e300;
        moved.row(t).setZero();
        for (int i : sole.vertices) {
          const double share = 1.0 / static_cast<double>(sole.vertices.size());
          track.centres.row(t) += share * frames_[t].row(i);
          track.lowest[t] = std::min(track.lowest[t], frames_[t](i, 2));
          moved.row(t) += share * poses[t].row(i);
        }
      }
      const std::vector<char> stands = FindContacts(track, height, 24);
      for (int t = 0; t + 1 < SizeOf(frames_); ++t)
        if (stands[t] && stands[t + 1])
          sum += (moved.row(t + 1) - moved.row(t)).norm() / height, ++count;
    }
    EXPECT_GT(count, 50);
    return sum / count;
  }

  Mesh body_;
  std::vector<PointsX3> frames_;
  std::vector<Mark> marks_;
};

TEST_F(LibraryWalk, FeetOfAShortLeggedBodyDoNotSlide) {
  if (!Prepare()) GTEST_SKIP() << "motion/ is not here; set KEYPOSE_DATA";
  const std::vector<PointsX3> standing = Transferred(true), sliding = Transferred(false);
  RecordProperty("slide_over_height", std::to_string(SlideOf(standing)));
  RecordProperty("slide_without_feet", std::to_string(SlideOf(sliding)));
  EXPECT_LT(SlideOf(standing), 0.1 * SlideOf(sliding));
  EXPECT_LT(SlideOf(standing), 2e-4);
  double lowest = 0;
  for (const PointsX3& pose : standing) lowest = std::min(lowest, pose.col(2).minCoeff());
  EXPECT_GT(lowest, -0.03 * target_.points.col(2).maxCoeff());
}

}  // namespace keypose::motion::programs_test
