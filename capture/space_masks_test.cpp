// Masks that agree in space, on a ring of photographs of a ball, whose outline is known exactly.
#include "capture/space_masks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "capture/capture_test_images.h"
#include "core/errors.h"
#include "core/io/colmap_io.h"
#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/io/image_set.h"
#include "core/parallel.h"

namespace keypose::capture {
namespace {
namespace fs = std::filesystem;

const SpaceOptions kCoarse{.resolution = 80};

constexpr int kWidth = 200, kHeight = 150, kViews = 18;
constexpr double kFocal = 220, kDistance = 4, kRadius = 0.7;  // the ball at the origin shows as a disc of 39 px radius

View RingView(int i) { return MakeTestView(i, kViews, kDistance, i % 2 ? 1.2 : 0.3, kWidth, kHeight, kFocal); }

bool OnBall(int x, int y) {
  const double sine = kRadius / kDistance, reach = kFocal * sine / std::sqrt(1 - sine * sine);
  return std::hypot(x + 0.5 - kWidth / 2.0, y + 0.5 - kHeight / 2.0) < reach;
}

/// A thing of the ball's colours that only some photographs show beside it, touching.
bool OnLamp(int x, int y) { return x > kWidth / 2 + 34 && x < kWidth / 2 + 64 && std::abs(y - kHeight / 2) < 9; }
/// A part of the ball that a photograph shows nearly as dark as the wall.
bool OnDark(int x, int y) { return OnBall(x, y) && x < kWidth / 2 - 10 && y > kHeight / 2 + 10; }

struct Ring {
  std::vector<View> views;
  std::vector<Image8> images, truths, masks;
};

/// Views 3 and 4 have the lamp in photograph and mask; view 9 lacks the dark part in both.
Ring MakeRing() {
  Ring ring;
  const Image8 wall = MakeTestWall(kWidth, kHeight, TestWall::kDark);
  for (int i = 0; i < kViews; ++i) {
    const Image8 clay = MakeTestPhoto(0, 3 * kWidth, 3 * kHeight, TestWall::kDark).image;  // its middle is clay all over
    Image8 image = wall, truth(kWidth, kHeight, 1, 0), mask(kWidth, kHeight, 1, 0);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const bool lamp = (i == 3 || i == 4) && OnLamp(x, y), dark = i == 9 && OnDark(x, y), ball = OnBall(x, y);
        if (ball || lamp) std::copy_n(clay.at(kWidth + (x + 7 * i) % 90 + 50, kHeight + (y + 3 * i) % 70 + 40), 3, image.at(x, y));
        for (int c = 0; dark && c < 3; ++c) image.at(x, y)[c] /= 3;
        *truth.at(x, y) = ball ? 255 : 0;
        *mask.at(x, y) = (ball && !dark) || lamp ? 255 : 0;
      }
    ring.views.push_back(RingView(i));
    ring.images.push_back(std::move(image));
    ring.truths.push_back(std::move(truth));
    ring.masks.push_back(std::move(mask));
  }
  return ring;
}

double Iou(const Image8& a, const Image8& b) {
  double both = 0, either = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i) both += a.data[i] > 127 && b.data[i] > 127, either += a.data[i] > 127 || b.data[i] > 127;
  return both / either;
}

TEST(DenialsByOthers, CountsTheOthersAndNeverTheViewItself) {
  const Ring ring = MakeRing();
  const std::vector<Image8> denials = DenialsByOthers(ring.views, ring.masks, kCoarse);
  EXPECT_EQ(*denials[0].at(kWidth / 2, kHeight / 2), 0);
  EXPECT_EQ(*denials[0].at(3, 3), 3);  // 18 views: a sixth
  // The part that view 9 lacks is denied by nobody else; a bright thing that two views show is denied by most.
  EXPECT_EQ(*denials[9].at(kWidth / 2 - 20, kHeight / 2 + 20), 0);
  EXPECT_GE(*denials[3].at(kWidth / 2 + 62, kHeight / 2), 3);
}

TEST(ThicknessOfHull, IsTheBallsChord) {
  Ring ring = MakeRing();
  const std::vector<Image8> thickness = ThicknessOfHull(ring.views, ring.truths, kCoarse);
  // The space is the ball and a voxel's margin; the hull of 18 views is a little larger than the ball.
  EXPECT_NEAR(*thickness[0].at(kWidth / 2, kHeight / 2), 97, 6);
  const double sine = 30 / std::hypot(30, kFocal) * kDistance / kRadius;  // of the ray that meets the image 30 pixels beside the middle
  EXPECT_NEAR(*thickness[0].at(kWidth / 2 + 30, kHeight / 2), 97 * std::sqrt(1 - sine * sine), 10);
  EXPECT_EQ(*thickness[0].at(3, 3), 0);
}

// Voxels of one pixel and a hull that two denials carve make the ball a pixel larger all round: 5 %; the hull of 18 views, some more.
TEST(AgreementInSpace, IsNearOneWhereMasksAreRightAndLowWhereOneIsNot) {
  Ring ring = MakeRing();
  const auto agreement = AgreementInSpace(ring.masks, DenialsByOthers(ring.views, ring.masks, kCoarse));
  EXPECT_GT(agreement[0], 0.88);
  EXPECT_LT(agreement[3], agreement[0] - 0.04);
  EXPECT_LT(agreement[9], agreement[0] - 0.04);
}

TEST(RefineInSpace, DropsWhatTwoViewsAddAndRestoresWhatOneLacks) {
  const Ring ring = MakeRing();
  ASSERT_LT(Iou(ring.masks[3], ring.truths[3]), 0.95);
  ASSERT_LT(Iou(ring.masks[9], ring.truths[9]), 0.90);
  const RefinedMasks refined = RefineInSpace(ring.images, ring.masks, ring.views, {}, {}, kCoarse);
  for (std::size_t i = 0; i < refined.masks.size(); ++i) EXPECT_GT(Iou(refined.masks[i], ring.truths[i]), 0.97) << "view " << i;
  EXPECT_GT(refined.agreement[3], refined.agreement_before[3]);
}

TEST(RefineInSpace, SameBitsForAnyThreadCount) {
  const Ring ring = MakeRing();
  SetThreadCount(1);
  const RefinedMasks one = RefineInSpace(ring.images, ring.masks, ring.views, {}, {}, kCoarse);
  SetThreadCount(4);
  const RefinedMasks four = RefineInSpace(ring.images, ring.masks, ring.views, {}, {}, kCoarse);
  SetThreadCount(0);
  for (std::size_t i = 0; i < one.masks.size(); ++i) EXPECT_EQ(one.masks[i].data, four.masks[i].data);
  EXPECT_EQ(one.agreement, four.agreement);
}

TEST(DenialsByOthers, BlackMasksAndMasksWithoutCommonSpaceThrow) {
  Ring ring = MakeRing();
  for (std::size_t i = 0; i < ring.views.size(); ++i)
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        *ring.masks[i].at(x, y) = x < 12 && y < 12 && i % 2 == 0 ? 255 : (x > kWidth - 12 && i % 2 ? 255 : 0);
  EXPECT_THROW(DenialsByOthers(ring.views, ring.masks, SpaceOptions{.most_denials = 2}), InputError);
  for (Image8& mask : ring.masks) mask = Image8(kWidth, kHeight, 1, 0);
  EXPECT_THROW(DenialsByOthers(ring.views, ring.masks, kCoarse), InputError);
}

/// Draws the ring's view i as if the ball stood elsewhere or were of another size [px].
void Redraw(Ring& ring, std::size_t i, double dx, double dy, double radius) {
  Image8& image = ring.images[i];
  const Image8 wall = MakeTestWall(kWidth, kHeight, TestWall::kDark);
  const Image8 clay = MakeTestPhoto(0, 3 * kWidth, 3 * kHeight, TestWall::kDark).image;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const bool on = std::hypot(x + 0.5 - kWidth / 2.0 - dx, y + 0.5 - kHeight / 2.0 - dy) < radius;
      std::copy_n(on ? clay.at(kWidth + x % 90 + 50, kHeight + y % 70 + 40) : wall.at(x, y), 3, image.at(x, y));
      *ring.masks[i].at(x, y) = *ring.truths[i].at(x, y) = on ? 255 : 0;
    }
}

TEST(JudgeOutlines, ViewThatDeniesWhatAllOthersUpholdLosesItsSayAndGivesTheirSpaceBack) {
  Ring ring = MakeRing();
  const std::vector<Image8> before = DenialsByOthers(ring.views, ring.truths, kCoarse);
  Redraw(ring, 7, 14, -9, 30);
  const auto by = [&](const std::vector<char>& say) { return Denials{DenialsByOthers(ring.views, ring.truths, kCoarse, say), 3}; };
  Denials denials = by({});
  EXPECT_NE(denials.pictures[0].data, before[0].data);  // it has carved
  const Standing standing = JudgeOutlines(ring.truths, denials, by, {});
  EXPECT_FALSE(standing.undecided);
  for (std::size_t i = 0; i < ring.views.size(); ++i) EXPECT_EQ(standing.say[i], i != 7) << i;
  EXPECT_GT(standing.fits[7].missing[0], 0.2);
  EXPECT_LT(standing.fits[0].missing[0], 0.01);
}

TEST(JudgeOutlines, TwoThatContradictInTheSameWayAreBothFound) {
  Ring ring = MakeRing();
  Redraw(ring, 7, 14, -9, 30);
  Redraw(ring, 8, 14, -9, 30);
  const auto by = [&](const std::vector<char>& say) { return Denials{DenialsByOthers(ring.views, ring.truths, kCoarse, say), 3}; };
  Denials denials = by({});
  const Standing standing = JudgeOutlines(ring.truths, denials, by, {});
  for (std::size_t i = 0; i < ring.views.size(); ++i) EXPECT_EQ(standing.say[i], i != 7 && i != 8) << i;
}

/// Six upright columns in a circle; only along the gaps that face each other does one see through.
bool OnColumns(const View& view, int x, int y) {
  const Eigen::Vector3d eye = view.camera_from_world.rotation.conjugate() * -view.camera_from_world.translation;
  const Eigen::Vector3d in_camera((x + 0.5 - kWidth / 2.0) / kFocal, (y + 0.5 - kHeight / 2.0) / kFocal, 1);
  const Eigen::Vector3d ray = view.camera_from_world.rotation.conjugate() * in_camera;
  for (int column = 0; column < 6; ++column) {
    const double angle = (10 + 60 * column) * M_PI / 180;
    const Eigen::Vector2d to = 0.55 * Eigen::Vector2d(std::cos(angle), std::sin(angle)) - eye.head<2>(), along = ray.head<2>();
    const double t = to.dot(along) / along.squaredNorm();
    if ((to - t * along).norm() < 0.2 && std::abs(eye.z() + t * ray.z()) < 0.6) return true;
  }
  return false;
}

TEST(JudgeOutlines, ToLookThroughBetweenColumnsIsNoFault) {
  Ring ring = MakeRing();
  for (std::size_t i = 0; i < ring.views.size(); ++i)
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) *ring.truths[i].at(x, y) = OnColumns(ring.views[i], x, y) ? 255 : 0;
  const auto by = [&](const std::vector<char>& say) { return Denials{DenialsByOthers(ring.views, ring.truths, kCoarse, say), 3}; };
  Denials denials = by({});
  // Some views lack far more than the middle one of what no other denies: they alone see through.
  const std::vector<OutlineFit> fits = FitsOfOutlines(ring.truths, denials, {});
  const auto most = std::max_element(fits.begin(), fits.end(), [](auto& a, auto& b) { return a.missing[0] < b.missing[0]; });
  ASSERT_GT(most->missing[0], 1.2 * StandingOptions{}.missing);
  const Standing standing = JudgeOutlines(ring.truths, denials, by, {});
  EXPECT_FALSE(standing.undecided);
  EXPECT_EQ(std::count(standing.say.begin(), standing.say.end(), 1), static_cast<std::ptrdiff_t>(ring.views.size()));
}

class MasksProgram : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "masks_test_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    root = pattern;
    ring = MakeRing();
    set.folder = root / "images";
    fs::create_directories(set.folder / "masks");
    for (std::size_t i = 0; i < ring.views.size(); ++i) {
      CapturedImage image;
      image.name = ring.views[i].name;
      image.width = kWidth, image.height = kHeight;
      image.mask = "masks/" + image.name + ".png";
      image.mask_given = i == 4;
      WriteImage(set.folder / image.name, ring.images[i]);
      WriteImage(set.folder / image.mask, ring.masks[i]);
      set.images.push_back(image);
    }
    WriteImageSet(set);
  }
  void TearDown() override { fs::remove_all(root); }

  int Run() const {
    fs::create_directories(root / "model");
    WriteColmapModel(root / "model", Scene{ring.views, {}});
    const std::string command = std::string(KEYPOSE_BIN_DIR) + "/keypose-masks --images " + set.folder.string() + " --model " +
                                (root / "model").string() + " --masked " + (root / "masked").string() + " --report " +
                                (root / "report.json").string() + " > " + (root / "log.txt").string() + " 2>&1";
    return WEXITSTATUS(std::system(command.c_str()));
  }

  fs::path root;
  Ring ring;
  ImageSet set;
};

TEST_F(MasksProgram, WritesAnImagesFolderAndLeavesTheUsersMasks) {
  ring.views.pop_back();  // a photograph without a camera keeps its mask
  ASSERT_EQ(Run(), 0) << ReadFile(root / "log.txt");
  const ImageSet masked = ReadImageSet(root / "masked");
  ASSERT_EQ(masked.images.size(), set.images.size());
  EXPECT_GT(Iou(ReadImage(masked.MaskPath(3), 1), ring.truths[3]), 0.97);
  EXPECT_EQ(ReadImage(masked.MaskPath(4), 1).data, ring.masks[4].data);
  EXPECT_EQ(ReadImage(masked.MaskPath(kViews - 1), 1).data, ring.masks[kViews - 1].data);
  EXPECT_EQ(ReadFile(masked.ImagePath(3)), ReadFile(set.ImagePath(3)));
  EXPECT_THAT(ReadFile(root / "report.json"), testing::HasSubstr("\"agreement_before\""));
}

TEST_F(MasksProgram, PhotographOfSomethingElseIsNamedAndLosesItsSay) {
  Redraw(ring, 7, 14, -9, 30);
  WriteImage(set.ImagePath(7), ring.images[7]);
  WriteImage(set.MaskPath(7), ring.masks[7]);
  ASSERT_EQ(Run(), 0) << ReadFile(root / "log.txt");
  const ImageSet masked = ReadImageSet(root / "masked");
  for (int i = 0; i < kViews; ++i) {
    EXPECT_EQ(masked.images[i].trusted, i != 7) << i;
    if (i == 7 || i == 4) continue;  // 4 has the user's own mask, lamp and all, which stays
    EXPECT_GT(Iou(ReadImage(masked.MaskPath(i), 1), ring.truths[static_cast<std::size_t>(i)]), 0.97) << i;
  }
  EXPECT_THAT(masked.images[7].why, testing::HasSubstr("of the figure that the other photographs agree on"));
  const std::string report = ReadFile(root / "report.json");
  EXPECT_THAT(report, testing::HasSubstr("\"distrusted\""));
  EXPECT_THAT(report, testing::HasSubstr(ring.views[7].name + " contradicts the other photographs"));
}

TEST_F(MasksProgram, PhotographOfAFigureOfTheSameOutlineAndOtherColoursIsNamed) {
  for (std::size_t p = 0; p < ring.images[7].data.size(); p += 3)
    if (ring.masks[7].data[p / 3]) ring.images[7].data[p] /= 6;  // hardly any red is left
  WriteImage(set.ImagePath(7), ring.images[7]);
  ASSERT_EQ(Run(), 0) << ReadFile(root / "log.txt");
  const ImageSet masked = ReadImageSet(root / "masked");
  for (int i = 0; i < kViews; ++i) EXPECT_EQ(masked.images[static_cast<std::size_t>(i)].trusted, i != 7) << i;
  EXPECT_THAT(masked.images[7].why, testing::HasSubstr("other colours"));
}

TEST(Touched, AreTheFewViewsThatHoldWhatTheOthersSeePast) {
  Standing standing;
  standing.say.assign(18, 1);
  standing.fits.resize(18);
  standing.fits[5].excess = 0.3;
  EXPECT_EQ(Touched(standing, {}), std::vector<std::size_t>{5});
  for (std::size_t i = 0; i < 9; ++i) standing.fits[i].excess = 0.3;  // a stand that half of them show
  EXPECT_TRUE(Touched(standing, {}).empty());
}

TEST_F(MasksProgram, FigureThatWasMovedHalfWayRoundIsAnInputErrorThatSaysWhatToDo) {
  for (std::size_t i = kViews / 2; i < kViews; ++i) {
    Redraw(ring, i, 25, 0, 39);
    WriteImage(set.ImagePath(static_cast<int>(i)), ring.images[i]);
    WriteImage(set.MaskPath(static_cast<int>(i)), ring.masks[i]);
  }
  EXPECT_EQ(Run(), 3);
  EXPECT_THAT(ReadFile(root / "log.txt"), testing::HasSubstr("shoot the rest again"));
  EXPECT_FALSE(fs::exists(root / "masked"));
}

TEST_F(MasksProgram, ModelOfOtherPhotographsIsAnInputError) {
  ring.views[2].name = "elsewhere.png";
  EXPECT_EQ(Run(), 3);
  EXPECT_THAT(ReadFile(root / "log.txt"), testing::HasSubstr("elsewhere.png"));
  EXPECT_FALSE(fs::exists(root / "masked"));
}

}  // namespace
}  // namespace keypose::capture
