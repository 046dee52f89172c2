// keypose-sfm as its users run it: a synthetic ring against its truth, the same bytes twice, and
// its errors.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/io/project/colmap_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"

namespace keypose::reconstruct::sfm_program_test {
namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

struct Outcome {
  int code = -1;
  std::string output;
};

class SfmProgram : public ::testing::Test, public TestingFolder {
 protected:
  Outcome Run(const std::string& environment, const std::string& program,
              const std::string& arguments) const {
    const fs::path log = root / "log.txt";
    const std::string command = environment + " " + BinFolder() + "/" + program + " " + arguments +
                                " > " + log.string() + " 2>&1";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, ReadFile(log)};
  }
  Outcome Sfm(const std::string& environment, const std::string& model,
              const std::string& options = "") const {
    return Run(environment, "keypose-sfm",
               "--images " + (root / "images").string() + " --model " + (root / model).string() +
                   " " + options);
  }

  static bool CanShoot() {
    return fs::exists(BinFolder() + "/keypose-synth") &&
           fs::exists(BinFolder() + "/keypose-capture");
  }

  static void TearDownTestSuite() { ring_.reset(); }

  /// Twenty photographs of the clay figure in one ring, as `images`, with their `truth`.
  bool ShootRing() const {
    if (!ring_ && !ShootFirstRing()) return false;
    for (const char* part : {"images", "truth"})
      fs::copy(ring_->path() / part, root / part, fs::copy_options::recursive);
    return true;
  }
  bool ShootFirstRing() const {
    ring_ = std::make_unique<TestingFolder>();
    const std::string folder = ring_->path().string();
    return Run("", "keypose-synth",
               "photos --output " + folder +
                   " --poses rest --views 20 --elevations 25 --width 640 --spacing 0.006")
                   .code == 0 &&
           Run("", "keypose-capture",
               "--photos " + folder + "/photos/rest --masks " + folder +
                   "/truth/rest/masks --images " + folder + "/images")
                   .code == 0;
  }

  /// A session of `keypose shoot` on the simulated set, imported as `images`.
  /// @param flags  of shoot: rings, angles, flips
  /// @param lost   names of photographs that are taken away before
  void ShootSession(const std::string& flags, const std::vector<std::string>& lost) const {
    const std::string project = (root / "fox").string();
    const Outcome session = Run("", "keypose-shoot",
                                "-C " + project + " --pose rest --turntable simulated --world " +
                                    (root / "set").string() + " " + flags + " < /dev/null");
    ASSERT_EQ(session.code, 0) << session.output;
    const fs::path photos = root / "fox/photos/rest";
    for (const std::string& name : lost) ASSERT_TRUE(fs::remove(photos / name)) << name;
    const Outcome imported =
        Run("", "keypose-capture",
            "--photos " + photos.string() + " --images " + (root / "images").string());
    ASSERT_EQ(imported.code, 0) << imported.output;
  }

  /// Eight images of unrelated noise, with full masks.
  void WriteUnrelatedImages() const {
    std::mt19937 random(3);
    ImageSet set;
    set.folder = root / "images";
    fs::create_directories(set.folder / "masks");
    for (int i = 0; i < 8; ++i) {
      Image8 coarse(40, 30, 3);
      for (std::uint8_t& v : coarse.data) v = static_cast<std::uint8_t>(random() % 256);
      CapturedImage image;
      image.name = "n" + std::to_string(i) + ".png";
      image.width = 320;
      image.height = 240;
      image.focal_px = 400;
      image.mask = "masks/" + image.name + ".png";
      WriteImage(set.folder / image.name, Resized(coarse, 320, 240));
      WriteImage(set.folder / image.mask, Image8(320, 240, 1, 255));
      set.images.push_back(image);
    }
    WriteImageSet(set);
  }

  const fs::path root = path();
  static inline std::unique_ptr<TestingFolder> ring_;  ///< drawn once for all tests
};
/// Tests of minutes.
class SfmProgramFull : public SfmProgram {};

std::string ModelBytes(const fs::path& model) {
  return ReadFile(model / "cameras.bin") + ReadFile(model / "images.bin") +
         ReadFile(model / "points3D.bin");
}

PointsX3 Centers(const Scene& scene) {
  PointsX3 centers(std::ssize(scene.views), 3);
  for (std::size_t v = 0; v < scene.views.size(); ++v)
    centers.row(v) = scene.views[v].Center().transpose();
  return centers;
}

TEST_F(SfmProgram, RingOfClayComesOutTrueUprightAndTheSameForAnyThreadCount) {
  if (!CanShoot()) GTEST_SKIP() << "keypose-synth and keypose-capture are not built here";
  ASSERT_TRUE(ShootRing());
  const Outcome one = Sfm("KEYPOSE_THREADS=1", "one"), two = Sfm("KEYPOSE_THREADS=2", "two");
  ASSERT_EQ(one.code, 0) << one.output;
  ASSERT_EQ(two.code, 0) << two.output;
  EXPECT_EQ(ModelBytes(root / "one") == ModelBytes(root / "two"), true);
  const Scene found = ReadColmapModel(root / "one"),
              truth = ReadColmapModel(root / "truth/rest/cameras");
  ASSERT_EQ(found.views.size(), truth.views.size());
  const Similarity3 align = FitSimilarity(Centers(found), Centers(truth));
  const PointsX3 moved = Transformed(align, Centers(found)), centers = Centers(truth);
  // The bound for real photographs; small images of a rendered ring are well within it.
  const double distance = centers.rowwise().norm().mean();
  EXPECT_LT((moved - centers).rowwise().norm().mean(), 0.005 * distance);
  // The turntable's axis is z in both, and the figure of 205 mm stands at z = 0. There are few
  // features at the feet, where the lowest ones are 9 mm and more above the ground. One ring at 25
  // degrees sees the lower 3 mm of the rounded feet from above only.
  EXPECT_NEAR((align * Eigen::Vector3d::Zero()).z(), 0, 0.003);
  EXPECT_GT((align.rotation * Eigen::Vector3d::UnitZ()).z(), std::cos(0.5 * 3.14159265 / 180));
}

// Every third photograph is of another camera: narrower, of fewer pixels, and of another shape.
TEST_F(SfmProgram, PhotographsOfTwoCamerasInTurnComeOutTrueWithALensEach) {
  if (!CanShoot()) GTEST_SKIP() << "keypose-synth and keypose-capture are not built here";
  const auto shoot = [&](const std::string& name, const std::string& flags) {
    const std::string shape = "photos --poses rest --views 20 --elevations 25 --spacing 0.006 ";
    return Run("", "keypose-synth", shape + "--output " + (root / name).string() + " " + flags);
  };
  ASSERT_EQ(shoot("a", "--width 800").code, 0);
  ASSERT_EQ(shoot("b", "--width 560 --height 560 --focal 50").code, 0);
  Scene truth = ReadColmapModel(root / "a/truth/rest/cameras");
  const Scene other = ReadColmapModel(root / "b/truth/rest/cameras");
  for (std::size_t i = 1; i < truth.views.size(); i += 3) {
    const fs::path photograph = fs::path("photos/rest") / truth.views[i].name;
    ASSERT_EQ(other.views[i].name, truth.views[i].name);
    const fs::path mask = "truth/rest/masks/" + truth.views[i].name + ".png";
    for (const fs::path& file : {photograph, mask})
      fs::copy_file(root / "b" / file, root / "a" / file, fs::copy_options::overwrite_existing);
    truth.views[i] = other.views[i];
  }
  ASSERT_EQ(
      Run("", "keypose-capture",
          "--photos " + (root / "a/photos/rest").string() + " --masks " +
              (root / "a/truth/rest/masks").string() + " --images " + (root / "images").string())
          .code,
      0);
  const Outcome outcome = Sfm("", "model");
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  const Scene found = ReadColmapModel(root / "model");
  ASSERT_EQ(found.views.size(), truth.views.size());
  const Similarity3 align = FitSimilarity(Centers(found), Centers(truth));
  const PointsX3 moved = Transformed(align, Centers(found)), centers = Centers(truth);
  const double distance = centers.rowwise().norm().mean();
  EXPECT_LT((moved - centers).rowwise().norm().mean(), 0.005 * distance);
  for (std::size_t i = 0; i < found.views.size(); ++i) {
    const Camera &lens = found.views[i].camera, &true_lens = truth.views[i].camera;
    EXPECT_EQ(lens.width, true_lens.width);
    EXPECT_NEAR(lens.fx, true_lens.fx, 0.02 * true_lens.fx);
  }
}

/// A photograph's number among those drawn, each `step_deg` of the table: r1_a036.jpg.
int DrawnNumber(const std::string& name, double step_deg) {
  return static_cast<int>(std::lround(std::stod(name.substr(4, 3)) / step_deg));
}

TEST_F(SfmProgram, AnglesOfASessionPlaceARingWithGapsThatNamesAloneDoNot) {
  if (!CanShoot() || !fs::exists(BinFolder() + "/keypose-shoot"))
    GTEST_SKIP() << "keypose-synth, keypose-capture and keypose-shoot are not built here";
  // So small that features alone do not do.
  ASSERT_EQ(Run("", "keypose-synth",
                "photos --output " + root.string() +
                    " --poses rest --views 20 --elevations 25 --width 240 --spacing 0.006")
                .code,
            0);
  ShootSession("--camera simulated:" + root.string() + " --rings 25 --angles 20",
               {"r1_a036.jpg", "r1_a054.jpg", "r1_a180.jpg", "r1_a306.jpg"});
  const fs::path report = root / "report.json";
  const Outcome with = Sfm("", "with", "--report " + report.string());
  ASSERT_EQ(with.code, 0) << with.output;
  const nlohmann::json measured = nlohmann::json::parse(ReadFile(report))["measurements"];
  EXPECT_EQ(measured["images_placed"], 16);
  EXPECT_EQ(measured["method"], "ring");
  EXPECT_EQ(measured["ring_layout"], "table angles of the shooting session");
  const Scene found = ReadColmapModel(root / "with"),
              truth = ReadColmapModel(root / "truth/rest/cameras");
  PointsX3 centers(std::ssize(found.views), 3);
  for (std::size_t v = 0; v < found.views.size(); ++v)
    centers.row(v) = truth.views[DrawnNumber(found.views[v].name, 18)].Center().transpose();
  const PointsX3 moved = Transformed(FitSimilarity(Centers(found), centers), Centers(found));
  // Features are few in pictures of 240 pixels; a wrong layout is off by a third of the distance.
  EXPECT_LT((moved - centers).rowwise().norm().mean(), 0.03 * centers.rowwise().norm().mean());

  ImageSet set = ReadImageSet(root / "images");
  for (CapturedImage& image : set.images) image.place.reset();
  WriteImageSet(set);
  const Outcome without = Sfm("", "without");
  EXPECT_EQ(without.code, 3) << without.output;
  EXPECT_THAT(without.output, HasSubstr("no cameras fit these photographs"));
}

TEST_F(SfmProgram, AnglesOfTwoPlacementsAreNotTakenForOneTurnOfTheTable) {
  if (!CanShoot()) GTEST_SKIP() << "keypose-synth and keypose-capture are not built here";
  ASSERT_TRUE(ShootRing());
  ImageSet set = ReadImageSet(root / "images");
  // Each placement has a table frame of its own, so these angles are no layout of one ring.
  for (int i = 0; i < std::ssize(set.images); ++i)
    set.images[i].place = {.ring = 1, .angle_deg = 18.0 * ((7 * i) % 20), .flip = i % 2};
  WriteImageSet(set);
  const fs::path report = root / "report.json";
  const Outcome outcome = Sfm("", "model", "--method ring --report " + report.string());
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  const nlohmann::json measured = nlohmann::json::parse(ReadFile(report))["measurements"];
  EXPECT_EQ(measured["images_placed"], 20);
  EXPECT_THAT(measured["ring_layout"].get<std::string>(), HasSubstr("1 ring of 20"));
}

TEST_F(SfmProgram, FewSmallFeaturesAreFoundAndALimitIsKept) {
  if (!CanShoot()) GTEST_SKIP() << "keypose-synth and keypose-capture are not built here";
  ASSERT_TRUE(ShootRing());
  const fs::path report = root / "report.json";
  const Outcome outcome = Sfm(
      "", "model",
      "--method features --max_features 1000 --guided_matching false --report " + report.string());
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  const nlohmann::json measured = nlohmann::json::parse(ReadFile(report))["measurements"];
  EXPECT_LE(measured["mean_features"].get<double>(), 1000);
  EXPECT_FALSE(measured.contains("guided_gain"));
}

TEST_F(SfmProgramFull, OptionsOfFeaturesMatchesAndLimitsDoWhatTheySay) {
  if (!CanShoot()) GTEST_SKIP() << "keypose-synth and keypose-capture are not built here";
  ASSERT_TRUE(ShootRing());
  const auto report = [&](const std::string& options) {
    const Outcome outcome = Sfm("", "model",
                                "--overwrite --method features --report " +
                                    (root / "report.json").string() + " " + options);
    EXPECT_EQ(outcome.code, 0) << outcome.output;
    return nlohmann::json::parse(ReadFile(root / "report.json"))["measurements"];
  };
  const nlohmann::json plain = report("");
  const double features = plain["mean_features"];
  EXPECT_TRUE(plain.contains("guided_gain"));
  const nlohmann::json few = report("--max_features 1000 --guided_matching false");
  EXPECT_LE(few["mean_features"].get<double>(), 1000);
  EXPECT_FALSE(few.contains("guided_gain"));
  EXPECT_LT(report("--peak_threshold 0.008")["mean_features"].get<double>(), 0.9 * features);
  EXPECT_NE(report("--affine_shape false")["mean_features"].get<double>(), features);
  EXPECT_LT(report("--max_image_size 400")["mean_features"].get<double>(), 0.9 * features);
  const Outcome strict = Sfm("", "strict", "--min_hull_overlap 1");
  EXPECT_NE(strict.code, 0);
  EXPECT_THAT(strict.output, HasSubstr("at least 1.00 is required"));
}

// Some 130 points a view, which let the pixels become 1.9 times as high as wide: fy 1733, fx 933.
TEST_F(SfmProgramFull, PixelsStaySquareWhereFewPointsHoldTheLens) {
  if (!CanShoot()) GTEST_SKIP() << "keypose-synth and keypose-capture are not built here";
  const std::string folder = root.string();
  ASSERT_EQ(Run("", "keypose-synth",
                "photos --output " + folder +
                    " --poses rest --views 20 --elevations 25 --width 480 --spacing 0.006")
                .code,
            0);
  ASSERT_EQ(Run("", "keypose-capture",
                "--photos " + folder + "/photos/rest --images " + folder + "/images")
                .code,
            0);
  ASSERT_EQ(Sfm("", "model").code, 0);
  constexpr double kTrue = 800;  // 60 mm of 36 at 480 pixels
  for (const View& view : ReadColmapModel(root / "model").views) {
    EXPECT_NEAR(view.camera.fy / view.camera.fx, 1, 1e-3);
    EXPECT_NEAR(view.camera.fx, kTrue, 0.02 * kTrue);
  }
}

TEST_F(SfmProgram, BoardGivesCamerasInMetresOfAFigureWithoutTexture) {
  if (!fs::exists(BinFolder() + "/keypose-synth") || !fs::exists(BinFolder() + "/keypose-capture"))
    GTEST_SKIP() << "keypose-synth and keypose-capture are not built here";
  ASSERT_EQ(Run("", "keypose-synth",
                "photos --output " + root.string() +
                    " --poses rest --views 10 --elevations 25,50 --width 720 --spacing 0.006 "
                    "--texture none --charuco")
                .code,
            0);
  ASSERT_EQ(
      Run("", "keypose-capture",
          "--photos " + (root / "photos/rest").string() + " --images " + (root / "images").string())
          .code,
      0);
  const std::string report = (root / "report.json").string();
  const Outcome outcome = Run("", "keypose-sfm",
                              "--images " + (root / "images").string() + " --model " +
                                  (root / "model").string() + " --report " + report);
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_THAT(ReadFile(report), HasSubstr("\"scale_source\": \"board\""));
  const Scene found = ReadColmapModel(root / "model"),
              truth = ReadColmapModel(root / "truth/rest/cameras");
  ASSERT_EQ(found.views.size(), truth.views.size());
  // No fit: the board's frame is the truth's. A twentieth of a pixel of the corners' mean is 0.1 mm
  // at 0.6 m; the focal length adds more.
  const PointsX3 error = Centers(found) - Centers(truth);
  EXPECT_LT(error.rowwise().norm().mean(), 0.003 * Centers(truth).rowwise().norm().mean());
  // Known poses as input give the same cameras back, to the last bits of a text file.
  const Outcome again =
      Run("", "keypose-sfm",
          "--images " + (root / "images").string() + " --model " + (root / "again").string() +
              " --poses " + (root / "truth/rest/cameras").string());
  ASSERT_EQ(again.code, 0) << again.output;
  EXPECT_LT((Centers(ReadColmapModel(root / "again")) - Centers(truth)).rowwise().norm().maxCoeff(),
            1e-9);
}

TEST_F(SfmProgram, PhotographsThatDoNotJoinAreAnInputErrorThatListsThem) {
  WriteUnrelatedImages();
  const Outcome outcome = Sfm("", "model");
  EXPECT_EQ(outcome.code, 3) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("do not join: only 0 of 8"));
  EXPECT_THAT(outcome.output, HasSubstr("n0.png, n1.png"));
  EXPECT_FALSE(fs::exists(root / "model"));
}

TEST_F(SfmProgram, MissingColmapIsAToolErrorThatNamesThePackage) {
  WriteUnrelatedImages();
  const Outcome outcome = Sfm("KEYPOSE_COLMAP=" + (root / "nothing").string(), "model");
  EXPECT_EQ(outcome.code, 5) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("apt-get install colmap"));
}

TEST_F(SfmProgram, MorePicturesThanTheMemoryHoldsAreSaidBeforeTheWork) {
#if defined(KEYPOSE_SANITIZED)
  GTEST_SKIP() << "a sanitizer's shadow needs all of the address space";
#endif
  WriteUnrelatedImages();
  ImageSet set = ReadImageSet(root / "images");
  for (CapturedImage& image : set.images) image.width = 16000, image.height = 16000;
  WriteImageSet(set);
  const Outcome outcome = Sfm("ulimit -v 3000000;", "model", "--max_image_size 20000");
  EXPECT_EQ(outcome.code, 4) << outcome.output;
  EXPECT_THAT(outcome.output,
              HasSubstr("the work on 8 photographs (2048 megapixels) needs 5.1 GB"));
  EXPECT_THAT(outcome.output, Not(HasSubstr("Processed file")));
}

TEST_F(SfmProgram, FolderThatIsNoImageSetIsAnInputError) {
  fs::create_directories(root / "images");
  const Outcome outcome = Sfm("", "model");
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.output, HasSubstr("capture.json"));
}

}  // namespace keypose::reconstruct::sfm_program_test
