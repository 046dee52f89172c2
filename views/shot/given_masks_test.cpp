#include "views/shot/given_masks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/png_io.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "views/decode/testing/test_film.h"

namespace keypose::given_masks_test {
namespace fs = std::filesystem;

using ::testing::HasSubstr;

/// 32 x 24: a block that is `high` on `low`, a pixel further right with each frame.
Image8 Block(int frame, int low, int high, int channels = 1) {
  Image8 block(32, 24, channels, static_cast<std::uint8_t>(low));
  for (int y = 8; y < 16; ++y)
    for (int x = 10 + frame; x < 18 + frame; ++x)
      std::fill_n(block.at(x, y), channels, static_cast<std::uint8_t>(high));
  return block;
}

class GivenMasksTest : public ::testing::Test, public TestingFolder {
 protected:
  void Put(int frame, const Image8& mask) const {
    fs::create_directories(folder_ / "masks/a");
    WritePng(folder_ / "masks/a" / (std::to_string(frame) + ".png"), mask);
  }
  GivenMasks Open() const { return GivenMasks(OpenShot(folder_).cameras[0], "track"); }
  void ExpectBlocks(GivenMasks masks) const {
    for (int frame = 0; frame < 3; ++frame)
      EXPECT_EQ(masks.Read(frame).data, Block(frame, 0, 255).data) << frame;
  }
};

TEST_F(GivenMasksTest, WhiteOnBlackIsReadAsItIsWithItsSoftBorder) {
  Image8 soft = Block(0, 0, 255);
  *soft.at(9, 10) = 90;
  Put(0, soft);
  GivenMasks masks = Open();
  EXPECT_EQ(masks.Read(0).data, soft.data);
  EXPECT_TRUE(masks.warnings().empty());
}

TEST_F(GivenMasksTest, LevelsOfOneAreWhite) {
  for (int frame = 0; frame < 3; ++frame) Put(frame, Block(frame, 0, 1));
  GivenMasks masks = Open();
  ASSERT_EQ(masks.warnings().size(), 1u);
  EXPECT_THAT(masks.warnings()[0],
              HasSubstr("track: the masks of camera a are not white on black"));
  ExpectBlocks(std::move(masks));
}

TEST_F(GivenMasksTest, AlphaIsTheMask) {
  for (int frame = 0; frame < 3; ++frame) {
    Image8 cutout(32, 24, 4, 180);
    const Image8 block = Block(frame, 0, 255);
    for (std::size_t p = 0; p < block.data.size(); ++p) cutout.data[4 * p + 3] = block.data[p];
    Put(frame, cutout);
  }
  ExpectBlocks(Open());
}

/// A picture in colours with this alpha.
Image8 CutOut(const Image8& alpha) {
  Image8 cutout(32, 24, 4);
  for (std::size_t p = 0; p < alpha.data.size(); ++p) {
    for (int c = 0; c < 3; ++c)
      cutout.data[4 * p + c] = static_cast<std::uint8_t>((p * 7 + c * 50) % 256);
    cutout.data[4 * p + 3] = alpha.data[p];
  }
  return cutout;
}

TEST_F(GivenMasksTest, ACutOutWithNobodyOrFilledByTheActorIsReadByItsAlphaToo) {
  const Image8 all(32, 24, 1, 255), nobody(32, 24, 1), block = Block(0, 0, 255);
  for (const auto& frames : {std::vector{block, nobody, all},
                             {all, block, nobody},
                             {nobody, all, block},
                             {nobody, block, nobody, all, nobody}}) {
    for (int frame = 0; frame < SizeOf(frames); ++frame) Put(frame, CutOut(frames[frame]));
    GivenMasks masks = Open();
    ASSERT_FALSE(masks.warnings().empty());
    EXPECT_THAT(masks.warnings()[0], HasSubstr("or their alpha, is taken for the actor"));
    for (int frame = 0; frame < SizeOf(frames); ++frame)
      EXPECT_EQ(masks.Read(frame).data, frames[frame].data) << frame;
  }
}

class GivenMaskFilm : public GivenMasksTest {
 protected:
  void SetUp() override {
    if (!TestFilm::CanWrite("qtrle")) GTEST_SKIP() << "libavcodec has no qtrle here";
  }
  /// A film of 32 x 24.
  /// @param levels  of its colours, one picture for all frames or one for each
  void Film(const std::vector<Image8>& alphas, const std::vector<Image8>& levels) const {
    fs::create_directories(folder_ / "masks");
    TestFilmKind kind;
    kind.codec = "qtrle", kind.pixels = AV_PIX_FMT_ARGB;
    kind.width = 32, kind.height = 24, kind.unit = 1000, kind.rate = 10;
    TestFilm film(folder_ / "masks/a.mov", kind);
    for (int i = 0; i < SizeOf(alphas); ++i)
      film.Add(100 * i, [&](AVFrame& frame) {
        for (int y = 0; y < 24; ++y)
          for (int x = 0; x < 32; ++x) {
            std::uint8_t* at = frame.data[0] + y * frame.linesize[0] + 4 * x;
            std::fill_n(at, 4, *levels[levels.size() == 1 ? 0 : i].at(x, y));
            at[0] = *alphas[i].at(x, y);
          }
      });
    film.Finish();
  }
};

TEST_F(GivenMaskFilm, ItsAlphaIsTheMask) {
  Film({Block(0, 0, 255), Block(1, 0, 255), Block(2, 0, 255)}, {Image8(32, 24, 1, 90)});
  GivenMasks masks = Open();
  EXPECT_EQ(masks.warnings().size(), 1u);
  ExpectBlocks(std::move(masks));
}

TEST_F(GivenMaskFilm, ItsAlphaIsTheMaskAlsoWhereItIsOpaqueOrTransparentAllOver) {
  const std::vector<Image8> alphas{Block(0, 0, 255), Image8(32, 24, 1, 255), Image8(32, 24, 1),
                                   Image8(32, 24, 1, 255)};
  Film(alphas, {Image8(32, 24, 1, 90)});
  GivenMasks masks = Open();
  for (int frame = 0; frame < SizeOf(alphas); ++frame)
    EXPECT_EQ(masks.Read(frame).data, alphas[frame].data) << frame;
}

TEST_F(GivenMaskFilm, WhereItsAlphaIsOpaqueItsLevelsCount) {
  std::vector<Image8> alphas, levels;
  for (int frame = 0; frame < 30; ++frame) {
    alphas.emplace_back(32, 24, 1, 255);
    levels.push_back(Block(frame % 10, 20, 90));
  }
  Film(alphas, levels);
  GivenMasks masks = Open();
  ASSERT_EQ(masks.warnings().size(), 1u);
  EXPECT_THAT(masks.warnings()[0], HasSubstr("are not white on black"));
  for (const int frame : {0, 1, 1, 2, 17, 29, 28})
    EXPECT_EQ(masks.Read(frame).data, Block(frame % 10, 0, 255).data) << frame;
}

TEST_F(GivenMasksTest, WhiteRoundTheActorIsTurnedRound) {
  for (int frame = 0; frame < 3; ++frame) Put(frame, Block(frame, 255, 0));
  GivenMasks masks = Open();
  ASSERT_EQ(masks.warnings().size(), 1u);
  EXPECT_THAT(masks.warnings()[0], HasSubstr("turned round"));
  ExpectBlocks(std::move(masks));
}

TEST_F(GivenMasksTest, WhiteAllOverAmongThoseIsAFrameWithoutTheActor) {
  for (int frame = 0; frame < 3; ++frame) Put(frame, Block(frame, 255, 0));
  Put(1, Image8(32, 24, 1, 255));
  GivenMasks masks = Open();
  ASSERT_EQ(masks.warnings().size(), 1u);
  EXPECT_THAT(masks.warnings()[0], HasSubstr("turned round"));
  EXPECT_EQ(masks.Read(0).data, Block(0, 0, 255).data);
  EXPECT_EQ(masks.Read(1).data, Image8(32, 24, 1).data);
}

TEST_F(GivenMasksTest, WhiteAllOverAmongOthersIsAFrameThatTheActorFills) {
  Put(0, Block(0, 0, 255));
  Put(1, Image8(32, 24, 1, 255));
  GivenMasks masks = Open();
  EXPECT_TRUE(masks.warnings().empty());
  EXPECT_EQ(masks.Read(1).data, Image8(32, 24, 1, 255).data);
}

TEST_F(GivenMasksTest, BlackOnesAreNamedAndOneOfThemAmongOthersIsNone) {
  for (int frame = 0; frame < 3; ++frame) Put(frame, Image8(32, 24, 1));
  const GivenMasks masks = Open();
  ASSERT_EQ(masks.warnings().size(), 1u);
  EXPECT_THAT(masks.warnings()[0], HasSubstr("black in all of the 3 frames"));
  Put(1, Block(1, 0, 255));
  EXPECT_TRUE(Open().warnings().empty()) << "the actor comes in later";
}

TEST_F(GivenMasksTest, ANearlyBlackJpegHoldsNobody) {
  fs::create_directories(folder_ / "masks/a");
  for (int frame = 0; frame < 3; ++frame) {
    Image8 mask = Block(frame, 0, 90);
    if (frame == 1)
      for (std::size_t p = 0; p < mask.data.size(); ++p)
        mask.data[p] = static_cast<std::uint8_t>(p * 7 / 3 % 4);
    WriteImage(folder_ / "masks/a" / (std::to_string(frame) + ".jpg"), mask, 100);
  }
  ASSERT_FALSE(ReadImage(folder_ / "masks/a/1.jpg", 1).data == Image8(32, 24, 1).data);
  GivenMasks masks = Open();
  EXPECT_EQ(masks.Read(1).data, Image8(32, 24, 1).data);
  EXPECT_EQ(*masks.Read(0).at(14, 12), 255);
}

TEST_F(GivenMasksTest, SeveralLabelsAreRefusedByName) {
  Image8 labels = Block(0, 0, 1);
  for (int x = 0; x < 20; ++x) *labels.at(x, 2) = 2;
  Put(0, labels);
  try {
    Open();
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("mask 0.png has the levels 0, 1, 2"));
  }
}

TEST_F(GivenMasksTest, HalfSizeAndAsStoredFitThePictures) {
  Put(0, Block(0, 0, 255));
  GivenMasks masks = Open();
  masks.FitTo(64, 48, 1);
  EXPECT_THAT(masks.warnings().back(), HasSubstr("were resized"));
  const Image8 twice = masks.Read(0);
  ASSERT_EQ(twice.width, 64);
  EXPECT_EQ(*twice.at(28, 24), 255);
  EXPECT_EQ(*twice.at(10, 24), 0);
  GivenMasks stored = Open();
  stored.FitTo(24, 32, 6);  // a quarter turn clockwise
  EXPECT_THAT(stored.warnings().back(), HasSubstr("turned as EXIF says"));
  const Image8 upright = stored.Read(0);
  ASSERT_EQ(upright.width, 24);
  EXPECT_EQ(*upright.at(12, 14), 255);
  EXPECT_EQ(*upright.at(12, 5), 0);
  EXPECT_THROW(Open().FitTo(48, 48, 1), InputError);
}

}  // namespace keypose::given_masks_test
