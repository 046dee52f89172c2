#include "capture/board/testing/seen_board.h"

#include <cmath>
#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>

namespace keypose::capture {
namespace {

constexpr int kSquare_px = 336;  // of the print: its markers lie within half of one

/// The print, drawn here and by OpenCV's markers, not by the code under test; its white rim is a
/// square wide.
cv::Mat PrintOf(const BoardPattern& pattern) {
  const int columns = pattern.layout.columns, rows = pattern.layout.rows;
  cv::Mat print((rows + 2) * kSquare_px, (columns + 2) * kSquare_px, CV_8UC1, cv::Scalar(255));
  const int side =
      static_cast<int>(std::lround(kSquare_px * pattern.layout.marker_m / pattern.layout.square_m));
  const auto words =
      cv::aruco::getPredefinedDictionary(cv::aruco::PREDEFINED_DICTIONARY_NAME(pattern.dictionary));
  int marker = 0;
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      const cv::Rect square((c + 1) * kSquare_px, (r + 1) * kSquare_px, kSquare_px, kSquare_px);
      if (((r + c) % 2 == 0) != pattern.first_white) {
        print(square).setTo(0);
      } else if (pattern.kind == BoardPattern::Kind::kCharuco) {
        cv::Mat drawn;
        cv::aruco::drawMarker(words, marker++, side, drawn, 1);
        const int inset = (kSquare_px - side) / 2;
        drawn.copyTo(print(cv::Rect(square.x + inset, square.y + inset, side, side)));
      }
    }
  if (pattern.inverted) cv::bitwise_not(print, print);
  return print;
}

}  // namespace

Image8 Photograph(const BoardPattern& pattern, const Seeing& seeing, int seed) {
  constexpr int kRays = 4;
  const View& view = seeing.view;
  const cv::Mat print = PrintOf(pattern);
  const double scale = kSquare_px / pattern.layout.square_m;
  std::vector<cv::Point2f> on_print, seen;
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    const Eigen::Vector3d p(x * pattern.layout.Width() / 2, y * pattern.layout.Height() / 2, 0);
    const Eigen::Vector2d pixel = view.Project(p);
    // pixel centres at .5 of both pictures; the print's y runs down
    on_print.emplace_back(static_cast<float>(print.cols / 2.0 + scale * p.x() - 0.5),
                          static_cast<float>(print.rows / 2.0 - scale * p.y() - 0.5));
    seen.emplace_back(static_cast<float>(kRays * pixel.x() - 0.5),
                      static_cast<float>(kRays * pixel.y() - 0.5));
  }
  cv::Mat fine, picture;
  cv::warpPerspective(print, fine, cv::getPerspectiveTransform(on_print, seen),
                      {kRays * view.camera.width, kRays * view.camera.height}, cv::INTER_LINEAR,
                      cv::BORDER_CONSTANT, cv::Scalar(120));
  cv::resize(fine, picture, {view.camera.width, view.camera.height}, 0, 0, cv::INTER_AREA);
  cv::GaussianBlur(picture, picture, {0, 0}, seeing.blur_px);
  picture.convertTo(picture, CV_32F, 0.7, 35);
  cv::Mat noise(picture.size(), CV_32F);
  cv::theRNG().state = static_cast<std::uint64_t>(seed);
  cv::randn(noise, 0, seeing.noise);
  picture += noise;
  if (seeing.mirrored) cv::flip(picture, picture, 1);
  Image8 image(view.camera.width, view.camera.height, 1);
  picture.convertTo(cv::Mat(image.height, image.width, CV_8UC1, image.data.data()), CV_8U);
  return image;
}

BoardPattern Charuco(int columns, int rows, int dictionary, double share) {
  BoardPattern pattern;
  pattern.layout = {columns, rows, 0.05, share * 0.05};
  pattern.dictionary = dictionary;
  return pattern;
}

BoardPattern Checkers(int columns, int rows) {
  BoardPattern pattern = Charuco(columns, rows, kOwnDictionary);
  pattern.kind = BoardPattern::Kind::kCheckerboard;
  return pattern;
}

}  // namespace keypose::capture
