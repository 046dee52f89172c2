// Films, as read by another program.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>
#include <sstream>

#include "core/numbers/parallel.h"
#include "core/pictures/render.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"
#include "export/film/film.h"
#include "views/film/mp4.h"

namespace keypose::exporting::film_test {

namespace fs = std::filesystem;
using Rgb = Eigen::Matrix<std::uint8_t, 3, 1>;

class Film : public ::testing::Test, public TestingFolder {
 protected:
  void SetUp() override {
    if (!CanWriteMp4()) GTEST_SKIP() << "libavcodec has no x264: run ./dev setup";
  }
};

Image8 Plain(int width, int height, const Rgb& color) {
  Image8 image(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) image.at(x, y)[c] = color[c];
  return image;
}

std::string BytesOf(const fs::path& path) {
  std::ostringstream bytes;
  bytes << std::ifstream(path, std::ios::binary).rdbuf();
  return bytes.str();
}

TEST_F(Film, AnotherProgramReadsEveryPictureInOrderWithItsColour) {
  const std::vector<Rgb> colors{
      {200, 60, 40}, {200, 60, 40}, {40, 160, 60}, {128, 128, 128}, {30, 60, 200}};
  Mp4Writer writer(folder_ / "film.mp4", 96, 64, 12);
  for (const Rgb& color : colors) writer.Add(Plain(96, 64, color));
  writer.Finish();
  cv::VideoCapture film((folder_ / "film.mp4").string(), cv::CAP_FFMPEG);
  ASSERT_TRUE(film.isOpened());
  EXPECT_DOUBLE_EQ(film.get(cv::CAP_PROP_FPS), 12);
  EXPECT_EQ(film.get(cv::CAP_PROP_FRAME_COUNT), 5);
  const int kind = static_cast<int>(film.get(cv::CAP_PROP_FOURCC));
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(&kind), 4), "avc1");
  cv::Mat picture;
  for (std::size_t i = 0; i < colors.size(); ++i) {
    ASSERT_TRUE(film.read(picture)) << i;
    ASSERT_EQ(picture.cols, 96);
    // OpenCV 4.6 decodes every film as BT.601, even if its header says BT.709: greens and reds
    // differ by up to about 20 levels.
    const cv::Vec3b bgr = picture.at<cv::Vec3b>(32, 48);
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(bgr[2 - c], colors[i][c], 30) << "picture " << i << " channel " << c;
  }
  EXPECT_FALSE(film.read(picture));
  EXPECT_LT(BytesOf(folder_ / "film.mp4").find("moov"), 64u)
      << "the index must come first, or browsers wait for the whole file";
}

TEST_F(Film, PictureWithAlphaLiesOverTheFilmsBackground) {
  Mp4Writer writer(folder_ / "film.mp4", 96, 64, 12);
  writer.Add(Image8(96, 64, 4));
  writer.Finish();
  cv::VideoCapture film((folder_ / "film.mp4").string(), cv::CAP_FFMPEG);
  cv::Mat picture;
  ASSERT_TRUE(film.read(picture));
  const cv::Vec3b bgr = picture.at<cv::Vec3b>(32, 48);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(bgr[2 - c], kFilmBackground[c], 3);
}

TEST_F(Film, PictureOfAnotherSizeThrowsInputError) {
  Mp4Writer writer(folder_ / "film.mp4", 96, 64, 12);
  EXPECT_THROW(writer.Add(Plain(64, 64, {1, 2, 3})), InputError);
}

TEST_F(Film, FileThatCannotBeWrittenThrowsDiskError) {
  EXPECT_THROW(Mp4Writer(folder_ / "no such folder" / "film.mp4", 96, 64, 12), DiskError);
}

/// A box whose top moves along x from frame to frame.
std::vector<Mesh> SwayingBox(int count) {
  std::vector<Mesh> frames(count, MakeBox(1, 1, 2));
  for (int i = 0; i < count; ++i)
    for (int v = 0; v < frames[i].vertex_count(); ++v)
      if (frames[i].points(v, 2) > 0) frames[i].points(v, 0) += 0.1 * i;
  return frames;
}

TEST_F(Film, SameBytesForAnyThreadCount) {
  const std::vector<Mesh> frames = SwayingBox(4);
  const std::vector<Image8> none;
  const auto bytes = [&](int threads, const std::string& name) {
    SetThreadCount(threads);
    Mp4Writer writer(folder_ / name, 128, 96, 24);
    RenderFilm(
        {frames, none, {}}, {0, 1, 2, 3}, {128, 96, -1, true, true},
        [&](const Image8& picture) { writer.Add(picture); }, nullptr);
    writer.Finish();
    SetThreadCount(0);
    return BytesOf(folder_ / name);
  };
  const std::string one = bytes(1, "one.mp4");
  EXPECT_GT(one.size(), 1000u);
  EXPECT_TRUE(one == bytes(4, "four.mp4"));
}

TEST(FilmFrames, HeldPicturesRepeatAndTheLastShowsForOneFrame) {
  const std::vector<Moment> glide{{0, 0, false}, {0.3, 0, false}, {0.4, 1, false}, {0.5, 2, false}};
  EXPECT_EQ(FilmFrames(glide, 10), (std::vector<int>{0, 0, 0, 0, 1, 2}));
  const std::vector<Moment> twos{{0, 0, true}, {0.1, 1, true}, {0.2, 2, true}, {0.3, 2, false}};
  EXPECT_EQ(FilmFrames(twos, 10), (std::vector<int>{0, 1, 2}));
}

TEST(AzimuthOfMotion, LooksAcrossTheMotion) {
  const double azimuth = AzimuthOfMotion(SwayingBox(3), {});
  const double from_y = std::abs(
      std::cos(azimuth * M_PI / 180));  // 1: looks along y, so that x is horizontal in the picture
  EXPECT_GT(from_y, 0.85) << azimuth;
}

// Motion on the far side is no reason to show the back.
TEST(AzimuthOfMotion, StaysOnTheFirstPhotographsSide) {
  for (const double at : {-1.0, 1.0}) {
    std::vector<Mesh> frames = SwayingBox(3);
    for (std::size_t i = 1; i < frames.size(); ++i)
      for (Eigen::Index v = 0; v < frames[i].points.rows(); ++v) {
        frames[i].points.row(v) = frames[0].points.row(v);
        if (at * frames[0].points(v, 1) > 0) frames[i].points(v, 0) += 0.1 * static_cast<double>(i);
      }
    EXPECT_GT(std::cos(AzimuthOfMotion(frames, {}) * M_PI / 180), 0.2);
  }
}

TEST(RenderFilm, BlendsTheTexturesByTheFramesWeights) {
  std::vector<Mesh> frames = SwayingBox(2);
  frames[0].uv_faces = FacesX3::Zero(frames[0].face_count(), 3);
  frames[0].uvs = UvsX2::Constant(1, 2, 0.5);
  const std::vector<Image8> textures{Plain(4, 4, {200, 0, 0}), Plain(4, 4, {0, 0, 200})};
  std::vector<Rgb> middle;
  RenderFilm(
      {frames, textures, {{1, 0}, {0.5, 0.5}}}, {0, 1}, {64, 48, 0, true, true},
      [&](const Image8& picture) {
        middle.push_back({picture.at(32, 24)[0], picture.at(32, 24)[1], picture.at(32, 24)[2]});
      },
      nullptr);
  ASSERT_EQ(middle.size(), 2u);
  EXPECT_EQ(middle[0][2], 0);
  EXPECT_GT(middle[0][0], 100);
  EXPECT_NEAR(middle[1][0], middle[1][2], 1) << "both textures by halves";
  EXPECT_GT(middle[1][0], 50);
}

Scene TwoKeys() {
  Scene scene;
  scene.frames = SwayingBox(5);
  scene.frame_names = {"frame_0000", "frame_0001", "frame_0002", "frame_0003", "frame_0004"};
  scene.clip = {{0, 1, 2, 3, 4}, {0, 0, 0, 0, 0}, false};
  scene.keys = {{1, "rest"}, {4, "bent"}, {2, "3"}};
  return scene;
}

TEST(FindFrame, ByKeyByNameAndByNumber) {
  const Scene scene = TwoKeys();
  EXPECT_EQ(FindFrame(scene, ""), 1) << "the first key";
  EXPECT_EQ(FindFrame(scene, "bent"), 4);
  EXPECT_EQ(FindFrame(scene, "frame_0002"), 2);
  EXPECT_EQ(FindFrame(scene, "0"), 0);
  EXPECT_EQ(FindFrame(scene, "3"), 2) << "a pose goes before a number";
  EXPECT_EQ(FindFrame(Scene{}, ""), 0);
}

TEST(FindFrame, UnknownFrameThrowsUsageErrorThatListsTheKeys) {
  for (const std::string wanted : {"5", "-1", "2x", "bend", "1.5"}) {
    try {
      FindFrame(TwoKeys(), wanted);
      FAIL() << wanted;
    } catch (const UsageError& error) {
      const std::string what = error.what();
      EXPECT_NE(what.find("'" + wanted + "'"), std::string::npos) << what;
      EXPECT_NE(what.find("0 to 4"), std::string::npos) << what;
      EXPECT_NE(what.find("rest, bent"), std::string::npos) << what;
    }
  }
}

TEST(RoundOf, FilmOfALoopEndsBeforeItsFirstPicture) {
  Scene scene = TwoKeys();
  EXPECT_EQ(RoundOf(scene), (std::vector<int>{0, 1, 2, 3, 4}));
  scene.playback.loop = "pingpong";
  EXPECT_EQ(RoundOf(scene), (std::vector<int>{0, 1, 2, 3, 4, 3, 2, 1}));
  scene.playback.loop = "none";
  scene.clip.loop = true;
  EXPECT_EQ(RoundOf(scene), (std::vector<int>{0, 1, 2, 3}));
}

/// Bounds of all frames in the pictures of some views, as shares of the width and height.
Eigen::AlignedBox2d BoundsSeen(const std::vector<Mesh>& frames, const std::vector<View>& views) {
  Eigen::AlignedBox2d box;
  for (const View& view : views)
    for (const Mesh& frame : frames)
      for (Eigen::Index v = 0; v < frame.points.rows(); ++v) {
        const Eigen::Vector2d p = view.Project(frame.points.row(v));
        box.extend(Eigen::Vector2d(p.x() / view.camera.width, p.y() / view.camera.height));
      }
  return box;
}

TEST(FilmView, ShowsAllFramesWithAMarginFromAbove) {
  const std::vector<Mesh> frames = SwayingBox(6);
  for (const bool shadow : {true, false})
    for (const int azimuth : {0, 60, 200}) {
      const FilmOptions options{640, 480, static_cast<double>(azimuth), true, shadow};
      const View view = FilmView(frames, options);
      const Eigen::AlignedBox2d seen = BoundsSeen(frames, {view});
      EXPECT_GT(seen.min().minCoeff(), 0.049) << azimuth;
      EXPECT_LT(seen.max().maxCoeff(), 0.951) << azimuth;
      const double filled = seen.sizes().maxCoeff();
      EXPECT_GT(filled, shadow ? 0.7 : 0.899) << "and fills the picture";
      EXPECT_GT(view.Center().z(), 1);
    }
}

TEST(FilmView, StandsAsHighAndSeesAsMuchAsIsAsked) {
  const std::vector<Mesh> frames = SwayingBox(6);
  for (const double elevation : {0.0, 14.0, 60.0})
    for (const double fov : {8.0, 28.0, 70.0}) {
      const FilmOptions options{.width = 640,
                                .height = 480,
                                .azimuth_deg = 30,
                                .shadow = false,
                                .elevation_deg = elevation,
                                .fov_deg = fov};
      const View view = FilmView(frames, options);
      const Eigen::Vector3d forward =
          view.camera_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
      EXPECT_NEAR(std::asin(-forward.z()) * 180 / M_PI, elevation, 1e-9);
      EXPECT_NEAR(2 * std::atan(240 / view.camera.fy) * 180 / M_PI, fov, 1e-9);
      const Eigen::AlignedBox2d seen = BoundsSeen(frames, {view});
      EXPECT_GT(seen.min().minCoeff(), 0.049) << elevation << " " << fov;
      EXPECT_NEAR(seen.sizes().maxCoeff(), 0.9, 1e-3) << "as large by any lens";
    }
}

TEST(FilmColor, IsANameOrSixDigits) {
  using Color = Eigen::Matrix<std::uint8_t, 3, 1>;
  EXPECT_EQ(*FilmColor("paper"), kFilmBackground);
  EXPECT_EQ(*FilmColor("black"), Color(0, 0, 0));
  EXPECT_EQ(*FilmColor("#1E90ff"), Color(30, 144, 255));
  for (const char* wrong :
       {"", "Paper", "#12345", "#1234567", "#12345g", "#-12345", "# 12345", "1E90ff"})
    EXPECT_FALSE(FilmColor(wrong)) << wrong;
}

TEST(TurntableViews, AllAreAtOneHeightAndDistanceAndEvenlySpaced) {
  Mesh box = MakeBox(1, 3, 2);
  box.points.col(0).array() += 7;  // far from the origin
  const FilmOptions options{640, 480, 40, true, true};
  const std::vector<View> views = TurntableViews(box, options, 24);
  const Eigen::Vector3d middle(7.5, 1.5, 0);
  for (int i = 0; i < 24; ++i) {
    const Eigen::Vector3d eye = views[i].Center() - middle;
    EXPECT_NEAR(eye.z(), views[0].Center().z(), 1e-9);
    EXPECT_NEAR(eye.norm(), (views[0].Center() - middle).norm(), 1e-9);
    const double azimuth = std::atan2(eye.x(), -eye.y()) * 180 / M_PI;
    EXPECT_NEAR(std::remainder(azimuth - (40 - 15 * i), 360), 0, 1e-6) << i;
    EXPECT_NEAR(views[i].Project(middle + Eigen::Vector3d(0, 0, 1)).x(), 320, 1e-6)
        << "the axis is in the middle";
  }
  const Eigen::AlignedBox2d seen = BoundsSeen({box}, views);
  EXPECT_GT(seen.min().minCoeff(), 0.049);
  EXPECT_LT(seen.max().maxCoeff(), 0.951);
}

double MeanDifference(const Image8& a, const Image8& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i) sum += std::abs(a.data[i] - b.data[i]);
  return sum / static_cast<double>(a.data.size());
}

TEST(RenderTurntable, LastPictureLeadsToTheFirst) {
  const std::vector<Mesh> frames = SwayingBox(3);
  const std::vector<Image8> none;
  std::vector<Image8> pictures;
  RenderTurntable(
      {frames, none, {}}, 2, 24, {128, 96, 10, true, true},
      [&](const Image8& picture) { pictures.push_back(picture); }, nullptr);
  ASSERT_EQ(pictures.size(), 96u) << "four seconds";
  std::vector<double> steps;
  for (int i = 0; i < 96; ++i) steps.push_back(MeanDifference(pictures[i], pictures[(i + 1) % 96]));
  const double join = steps.back();
  EXPECT_GT(join, 0);
  EXPECT_LT(join, 1.5 * std::max(steps[0], steps[94])) << "no jump, and no picture twice";
  EXPECT_GT(join, 0.5 * std::min(steps[0], steps[94]));
  EXPECT_GT(MeanDifference(pictures[0], pictures[12]), 3 * join) << "it does turn";
}

TEST(RenderTurntable, FirstPictureIsSeenFromTheFilmsSide) {
  const std::vector<Mesh> frames = SwayingBox(3);
  const std::vector<Image8> none;
  FilmOptions options{64, 48, -1, true, false};
  Image8 first;
  RenderTurntable(
      {frames, none, {}}, 0, 0.25, options, [&](const Image8& picture) { first = picture; },
      nullptr);
  options.azimuth_deg = AzimuthOfMotion(frames, options);
  const View view = TurntableViews(frames[0], options, 1)[0];
  EXPECT_EQ(first.data, RenderPicture({frames, none, {}}, 0, view, nullptr).data);
}

TEST(TurntablePictures, AreFourSecondsAndAtLeastOne) {
  EXPECT_EQ(TurntablePictures(24), 96);
  EXPECT_EQ(TurntablePictures(12.5), 50);
  EXPECT_EQ(TurntablePictures(0.1), 1);
}

}  // namespace keypose::exporting::film_test
