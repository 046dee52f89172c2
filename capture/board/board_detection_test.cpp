#include "capture/board/board_detection.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/imgproc.hpp>

#include "capture/board/board_print.h"
#include "core/values/calibration_board.h"
#include "core/values/camera.h"

namespace keypose::capture::board_detection_test {

cv::Mat View(const Image8& image) {
  return {image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.data.data())};
}

/// The board as a camera sees it, with 3 x 3 rays per pixel; `hidden` is covered by a grey object.
Image8 Photograph(const BoardLayout& board, const keypose::View& view,
                  const std::function<bool(double, double)>& hidden) {
  constexpr double kScale = 10;
  const Page page = PageNamed("A4");
  const Image8 picture = BoardPicture(board, page, kScale);
  const Camera& camera = view.camera;
  Image8 image(camera.width, camera.height, 1);
  const Rigid3 world_from_camera = view.camera_from_world.Inverse();
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      double sum = 0;
      for (int k = 0; k < 9; ++k) {
        const Eigen::Vector2d pixel(x + (k % 3 + 0.5) / 3, y + (k / 3 + 0.5) / 3);
        const Eigen::Vector3d ray = world_from_camera.rotation * camera.Unproject(pixel),
                              eye = world_from_camera.translation;
        const Eigen::Vector3d p = eye - ray * (eye.z() / ray.z());
        const int px = static_cast<int>(kScale * (page.width_mm / 2 + 1000 * p.x())),
                  py = static_cast<int>(kScale * (page.height_mm / 2 - 1000 * p.y()));
        const bool on =
            ray.z() < 0 && px >= 0 && py >= 0 && px < picture.width && py < picture.height;
        sum += hidden(p.x(), p.y()) ? 110 : on ? 30 + *picture.at(px, py) * 0.7 : 120;
      }
      *image.at(x, y) = static_cast<std::uint8_t>(std::lround(sum / 9));
    }
  cv::GaussianBlur(View(image), View(image), {0, 0}, 0.7);
  return image;
}

keypose::View ViewFrom(double elevation_deg) {
  keypose::View view;
  view.camera.width = 1000, view.camera.height = 700;
  view.camera.fx = view.camera.fy = 1900, view.camera.cx = 503, view.camera.cy = 352;
  view.camera.k1 = -0.06;
  const double e = elevation_deg * 3.14159265 / 180;
  const Eigen::Vector3d eye =
      0.55 * Eigen::Vector3d(0.3 * std::cos(e), -std::sqrt(1 - 0.09) * std::cos(e), std::sin(e));
  const Eigen::Vector3d z = -eye.normalized(), x = z.cross(Eigen::Vector3d::UnitZ()).normalized(),
                        y = z.cross(x);
  Eigen::Matrix3d rotation;
  rotation << x.transpose(), y.transpose(), z.transpose();
  view.camera_from_world.rotation = rotation;
  view.camera_from_world.translation = -(view.camera_from_world.rotation * eye);
  return view;
}

TEST(BoardDetection, CornersAreWhereTheCameraSeesThem) {
  const BoardLayout board;
  for (const double elevation : {15.0, 45.0}) {
    const keypose::View view = ViewFrom(elevation);
    const auto corners =
        FindBoard(Photograph(board, view, [](double, double) { return false; }), board);
    ASSERT_GE(corners.size(), 60u) << elevation;
    double sum = 0;
    for (const BoardCorner& corner : corners)
      sum += (corner.pixel - view.Project(board.Corner(corner.id))).squaredNorm();
    EXPECT_LT(std::sqrt(sum / static_cast<double>(corners.size())), 0.03)
        << elevation;  // eight bits per pixel allow a hundredth
  }
}

TEST(BoardDetection, HiddenCornersAreNotGuessed) {
  const BoardLayout board;
  const keypose::View view = ViewFrom(40);
  const auto hidden = [](double x, double y) { return std::abs(x) < 0.05 && std::abs(y) < 0.04; };
  const auto corners = FindBoard(Photograph(board, view, hidden), board);
  EXPECT_GE(corners.size(), 40u);
  for (const BoardCorner& corner : corners) {
    const Eigen::Vector3d at = board.Corner(corner.id);
    EXPECT_FALSE(hidden(at.x(), at.y())) << corner.id;
    EXPECT_LT((corner.pixel - view.Project(at)).norm(), 0.5) << corner.id;
  }
}

TEST(BoardDetection, PictureWithoutABoardGivesNone) {
  Image8 image(640, 480, 3);
  for (std::size_t i = 0; i < image.data.size(); ++i)
    image.data[i] = static_cast<std::uint8_t>((i * 2654435761u) >> 24);
  EXPECT_TRUE(FindBoard(image, {}).empty());
}

/// In colour: the object is teal, and the board beside it lies in its shadow.
Image8 InColor(const Image8& grey, const Image8& object) {
  Image8 rgb(grey.width, grey.height, 3);
  cv::Mat shadow;
  cv::GaussianBlur(View(object), shadow, {0, 0}, 8);
  for (std::size_t p = 0; p < grey.data.size(); ++p) {
    const double light = 1 - 0.45 * shadow.data[p] / 255.0, own = object.data[p] / 255.0;
    for (int c = 0; c < 3; ++c) {
      const double teal[] = {40, 125, 130};
      rgb.data[3 * p + static_cast<std::size_t>(c)] =
          static_cast<std::uint8_t>(std::lround((1 - own) * light * grey.data[p] + own * teal[c]));
    }
  }
  return rgb;
}

struct Judged {
  double board = 0, object = 0;  ///< shares that are judged rightly
};

/// The odds for a smaller copy of a photograph, against where the object is.
Judged JudgeReduced(const Image8& rgb, const Image8& object,
                    const std::vector<BoardCorner>& corners, double width_px) {
  const double factor = width_px / rgb.width;
  const cv::Size size(static_cast<int>(width_px),
                      static_cast<int>(std::lround(factor * rgb.height)));
  Image8 small(size.width, size.height, 3), truth(size.width, size.height, 1);
  cv::Mat small_view(size, CV_8UC3, small.data.data()), truth_view = View(truth);
  cv::resize(cv::Mat(rgb.height, rgb.width, CV_8UC3, const_cast<std::uint8_t*>(rgb.data.data())),
             small_view, size, 0, 0, cv::INTER_AREA);
  cv::resize(View(object), truth_view, size, 0, 0, cv::INTER_AREA);
  const BoardOdds odds = OddsOfBoard(small, corners, factor, {}, 6);
  std::array<double, 2> right = {0, 0}, all = {0, 0};
  for (std::size_t p = 0; p < truth.data.size(); ++p) {
    const bool hidden = truth.data[p] == 255;
    if (!odds.on_board.data[p] || (truth.data[p] != 0 && !hidden)) continue;
    ++all[hidden];
    right[hidden] += (odds.odds.data[p] > 0) == hidden;
  }
  return {right[0] / all[0], right[1] / all[1]};
}

std::vector<Judged> JudgeBoard(double elevation, const std::vector<double>& widths_px) {
  const BoardLayout board;
  const auto in_disc = [](double x, double y) { return std::hypot(x - 0.01, y) < 0.04; };
  const keypose::View view = ViewFrom(elevation);
  const Image8 grey = Photograph(board, view, [](double, double) { return false; });
  Image8 object(grey.width, grey.height, 1, 0);
  const Rigid3 world_from_camera = view.camera_from_world.Inverse();
  for (int y = 0; y < grey.height; ++y)
    for (int x = 0; x < grey.width; ++x) {
      const Eigen::Vector3d ray = world_from_camera.rotation *
                                  view.camera.Unproject({x + .5, y + .5}),
                            eye = world_from_camera.translation,
                            at = eye - ray * (eye.z() / ray.z());
      if (ray.z() < 0 && in_disc(at.x(), at.y())) *object.at(x, y) = 255;
    }
  const Image8 rgb = InColor(grey, object);
  const std::vector<BoardCorner> corners = FindBoard(rgb, board);
  std::vector<Judged> judged;
  for (const double width : widths_px) judged.push_back(JudgeReduced(rgb, object, corners, width));
  return judged;
}

TEST(BoardOdds, KnowThePrintFromWhatStandsOnItAlsoWhereSquaresAreSmall) {
  for (const double elevation : {15.0, 45.0})
    for (const Judged& judged : JudgeBoard(elevation, {1000, 512, 400})) {
      EXPECT_GT(judged.board, 0.99) << elevation << " deg";
      EXPECT_GT(judged.object, 0.98) << elevation << " deg";
    }
}

}  // namespace keypose::capture::board_detection_test
