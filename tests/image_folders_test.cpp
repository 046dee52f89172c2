// Realistic folders of photographs: shuffled, with missing, rotated, duplicate or truncated files,
// or with wrong EXIF. Each either gives the same cameras as a clean folder, or a message that names
// the faulty photographs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <memory>
#include <random>

#include "core/io/pictures/image_io.h"
#include "core/io/project/colmap_io.h"
#include "core/testing/folder.h"
#include "core/values/camera.h"
#include "core/values/size_of.h"
#include "tests/run_program.h"

namespace keypose::tests::image_folders_test {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr int kOk = 0, kInput = 3, kViews = 30;

std::string NameOf(int view) {
  char name[32];
  std::snprintf(name, sizeof name, "IMG_%04d.jpg", view);
  return name;
}

/// Errors of a model's cameras.
struct CameraErrors {
  int placed = 0;
  double mean = 0,
         largest = 0;  // relative to the cameras' mean distance from the turntable's middle
  double focal = 0;    // relative
};

class ImageFolders : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    world_ = std::make_unique<TestingFolder>();
    const RunResult made =
        RunProgram({"keypose-synth", "photos", "--output", world_->path(), "--poses", "rest",
                    "--views", std::to_string(kViews), "--elevations", "25", "--width", "560",
                    "--height", "420", "--spacing", "0.006"},
                   world_->path());
    ASSERT_EQ(made.exit_code, kOk) << made.output;
  }
  static void TearDownTestSuite() { world_.reset(); }

  void SetUp() override {
    fs::create_directories(photos());
    for (int i = 1; i <= kViews; ++i)
      fs::copy_file(world_->path() / "photos/rest" / NameOf(i), photos() / NameOf(i)),
          truth_name_[NameOf(i)] = NameOf(i);
  }

  fs::path photos() const { return folder_.path() / "photos"; }
  void Drop(int view) { fs::remove(photos() / NameOf(view)), truth_name_.erase(NameOf(view)); }
  /// Enough for what capture alone says; cameras are sought from all.
  void KeepOnlyTheFirstTwelve() {
    for (int view = 13; view <= kViews; ++view) Drop(view);
  }
  /// Gives the files names that are independent of the order on the turntable.
  void Shuffle(unsigned seed) {
    std::vector<std::string> names;
    for (const auto& [name, truth] : truth_name_) names.push_back(name);
    std::vector<std::string> shuffled = names;
    std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(seed));
    std::map<std::string, std::string> renamed;
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::string to = "S" + shuffled[i];
      fs::rename(photos() / names[i], photos() / to);
      renamed[to] = truth_name_[names[i]];
    }
    truth_name_ = renamed;
  }
  void Spoil(const std::string& kind, const std::string& names) {
    const fs::path clean = folder_.path() / "clean";
    fs::rename(photos(), clean);
    const RunResult made = RunProgram({"keypose-synth", "damage", "--photos", clean, "--output",
                                       photos(), "--kind", kind, "--names", names},
                                      folder_.path());
    ASSERT_EQ(made.exit_code, kOk) << made.output;
    fs::remove_all(clean);
  }
  /// Sets another focal length in the EXIF of all photographs.
  void ClaimFocal35(double focal_35mm) {
    ExifToWrite exif;
    exif.focal_35mm = focal_35mm, exif.focal_mm = focal_35mm / 1.5;
    exif.make = "Keypose", exif.model = "Synthetic APS-C";
    for (const auto& [name, truth] : truth_name_) {
      const Image8 image = ReadImage(photos() / name);
      WriteImage(photos() / name, image, 95, &exif);
    }
  }

  RunResult Capture() {
    return RunProgram(
        {"keypose", "capture", "--photos", photos(), "--images", folder_.path() / "images"},
        folder_.path());
  }
  RunResult Sfm() {
    return RunProgram({"keypose", "sfm", "--images", folder_.path() / "images", "--model",
                       folder_.path() / "model"},
                      folder_.path());
  }

  CameraErrors Errors() const {
    const Scene found = ReadColmapModel(folder_.path() / "model"),
                truth = ReadColmapModel(world_->path() / "truth/rest/cameras");
    std::map<std::string, const View*> by_name;
    for (const View& view : truth.views) by_name[view.name] = &view;
    const Eigen::Index count = std::ssize(found.views);
    PointsX3 a(count, 3), b(count, 3);
    for (Eigen::Index i = 0; i < count; ++i) {
      a.row(i) = found.views[i].Center().transpose();
      b.row(i) = by_name.at(truth_name_.at(found.views[i].name))->Center().transpose();
    }
    const Eigen::VectorXd errors =
        (Transformed(FitSimilarity(a, b), a) - b).rowwise().norm() / b.rowwise().norm().mean();
    return {static_cast<int>(count), errors.mean(), errors.maxCoeff(),
            found.views[0].camera.fx / truth.views[0].camera.fx - 1};
  }

  /// Expects that capture and sfm succeed, and that all cameras are in their true places.
  void ExpectRight(double most_mean = 0.006) {
    const RunResult captured = Capture();
    ASSERT_EQ(captured.exit_code, kOk) << captured.output;
    const RunResult placed = Sfm();
    ASSERT_EQ(placed.exit_code, kOk) << placed.output;
    const CameraErrors errors = Errors();
    EXPECT_EQ(errors.placed, SizeOf(truth_name_));
    EXPECT_LT(errors.mean, most_mean);
    EXPECT_LT(errors.largest, 4 * most_mean);
  }
  /// Expects that capture fails with these words, and leaves no output.
  void ExpectRefused(const std::vector<std::string>& words) {
    const RunResult captured = Capture();
    EXPECT_EQ(captured.exit_code, kInput) << captured.output;
    for (const std::string& word : words) EXPECT_THAT(captured.output, HasSubstr(word));
    EXPECT_FALSE(fs::exists(folder_.path() / "images"));
  }

  TestingFolder folder_;
  std::map<std::string, std::string> truth_name_;  // per photograph in the folder
  static inline std::unique_ptr<TestingFolder> world_;
};
/// One thing at a time, where the short tests take them together.
class ImageFoldersFull : public ImageFolders {};

TEST_F(ImageFolders, AllThatIsHarmlessTogetherGivesTheSameRing) {
  for (const int view : {3, 7, 8, 17, 24}) Drop(view);
  ClaimFocal35(85);  // the true value is 60
  Spoil("rotate", NameOf(2) + "," + NameOf(9) + "," + NameOf(18));
  Shuffle(5);
  ExpectRight();
  EXPECT_NEAR(Errors().focal, 0, 0.03);
}

TEST_F(ImageFoldersFull, ShuffledNamesTurnedPhotographsAndFiveMissingViewsGiveTheSameRing) {
  for (const int view : {3, 7, 8, 17, 24}) Drop(view);
  Spoil("rotate", NameOf(2) + "," + NameOf(9) + "," + NameOf(18));
  Shuffle(5);
  ExpectRight();
}

TEST_F(ImageFoldersFull, WrongFocalLengthInExifIsFoundOut) {
  ClaimFocal35(85);  // the true value is 60
  ExpectRight();
  EXPECT_NEAR(Errors().focal, 0, 0.03);
}

TEST_F(ImageFoldersFull, OnePhotographOutOfFocusDoesNotSpoilTheOthers) {
  Spoil("blur", NameOf(5));
  const RunResult captured = Capture();
  ASSERT_EQ(captured.exit_code, kOk) << captured.output;
  ASSERT_EQ(Sfm().exit_code, kOk);
  const CameraErrors errors = Errors();
  EXPECT_GE(errors.placed, kViews - 1);
  EXPECT_LT(errors.mean, 0.006);
}

TEST_F(ImageFolders, CopiesUnderAnotherNameAreNamed) {
  KeepOnlyTheFirstTwelve();
  fs::copy_file(photos() / NameOf(4), photos() / "IMG_0099.jpg");
  ExpectRefused({"IMG_0099.jpg", NameOf(4)});
}

TEST_F(ImageFolders, EachOfSeveralFaultsIsNamed) {
  KeepOnlyTheFirstTwelve();
  Spoil("truncate", NameOf(6) + "," + NameOf(11));
  ExpectRefused({NameOf(6), NameOf(11)});
}

// A photograph of another size is taken for one of another lens, which one photograph tells badly.
TEST_F(ImageFolders, PhotographsOfAnotherSizeAreNamed) {
  KeepOnlyTheFirstTwelve();
  Spoil("resize", NameOf(10));
  const RunResult captured = Capture();
  EXPECT_EQ(captured.exit_code, kOk) << captured.output;
  EXPECT_THAT(captured.output, HasSubstr("1 is 448 x 336: " + NameOf(10)));
}

// Random mixtures of harmless and harmful faults: harmful ones are refused with the file's name;
// all others give the correct ring.
TEST_F(ImageFolders, RandomHarmfulMixturesAreRefusedByName) {
  std::mt19937 random(11);
  const std::vector<std::string> kinds = {"truncate", "empty", "no-image"};
  for (int round = 0; round < 6; ++round) {
    fs::remove_all(photos());
    truth_name_.clear();
    SetUp();
    KeepOnlyTheFirstTwelve();
    const int victim = 1 + static_cast<int>(random() % 12), missing = 1 + (victim + 3) % 12;
    const std::string kind = kinds[random() % kinds.size()];
    Drop(missing);
    Spoil(kind, NameOf(victim));
    SCOPED_TRACE(kind + " " + NameOf(victim));
    ExpectRefused({NameOf(victim)});
  }
}

}  // namespace keypose::tests::image_folders_test
