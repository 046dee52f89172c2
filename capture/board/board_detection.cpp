#include "capture/board/board_detection.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "capture/board/markers.h"
#include "capture/board/print_match.h"
#include "core/numbers/statistics.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::capture {
namespace {

constexpr double kLeastSquare_px = 6;

// Chosen on the rendered boards of board_detection_test.cpp; kEven by the masks of a set with the
// board (docs/algorithms/capture.md), which the record does not name. Sensitivity:
// docs/results/sensitivity.md.
struct BoardDetectionTuning {
  KEYPOSE_TUNED(double, kContrast, 20);  // grey levels; least difference between paper and ink
  // least correlation with the print around a corner; an occluding figure lowers it
  KEYPOSE_TUNED(double, kCorrelation, 0.9);
  // grey levels over three channels; distance from the print at which print and object are equally
  // likely
  KEYPOSE_TUNED(double, kEven, 30);
};

/// Corner k of a marker on the board, clockwise from its top left; y up.
cv::Point2d MarkerCorner(const BoardPattern& pattern, int marker, int k) {
  const BoardLayout& board = pattern.layout;
  const auto [column, row] = pattern.SquareOf(marker);
  const double half = board.marker_m / 2, x = (column + 0.5) * board.square_m - board.Width() / 2,
               y = board.Height() / 2 - (row + 0.5) * board.square_m;
  return {x + (k == 1 || k == 2 ? half : -half), y + (k < 2 ? half : -half)};
}

/// Marker corners on the board and in the photograph.
struct MarkerPoints {
  std::vector<cv::Point2d> board, image;
};

MarkerPoints PlacedMarkers(const Image8& grey, const BoardPattern& pattern, bool thorough) {
  MarkerPoints points;
  for (const SeenMarker& marker : FindMarkers(grey, pattern.dictionary, thorough)) {
    if (marker.id >= pattern.MarkerCount()) continue;
    for (int k = 0; k < 4; ++k) {
      points.board.push_back(MarkerCorner(pattern, marker.id, k));
      points.image.emplace_back(marker.corners[k].x(), marker.corners[k].y());
    }
  }
  return points;
}

cv::Point2d Map(const cv::Matx33d& h, const cv::Point2d& p) {
  const cv::Vec3d q = h * cv::Vec3d(p.x, p.y, 1);
  return {q[0] / q[2], q[1] / q[2]};
}

/// A homography plus the smooth residuals of the marker corners, from lens distortion.
class BoardMap {
 public:
  explicit BoardMap(const MarkerPoints& points, double square_m) : square_m_(square_m) {
    if (points.board.size() < 8) return;
    std::vector<std::uint8_t> inlier;
    const cv::Mat h =
        cv::findHomography(points.board, points.image, cv::RANSAC, 6, inlier, 2000, 0.999);
    if (h.empty()) return;
    h_ = cv::Matx33d(h.ptr<double>());
    board_from_image_ = h_.inv();
    for (std::size_t i = 0; i < inlier.size(); ++i) {
      if (!inlier[i]) continue;
      places_.push_back(points.board[i]);
      misses_.push_back(points.image[i] - Map(h_, points.board[i]));
    }
    found_ = places_.size() >= 8;
  }
  bool found() const { return found_; }
  cv::Point2d operator()(const cv::Point2d& on_board) const {
    return Map(h_, on_board) + Miss(on_board);
  }
  /// The position of a pixel on the board.
  cv::Point2d OnBoard(const cv::Point2d& pixel) const {
    cv::Point2d p = Map(board_from_image_, pixel);
    for (int round = 0; round < 2; ++round) p = Map(board_from_image_, pixel - Miss(p));
    return p;
  }

 private:
  cv::Point2d Miss(const cv::Point2d& on_board) const {
    cv::Point2d sum(0, 0);
    double total = 1e-3;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const cv::Point2d d = (places_[i] - on_board) / (1.5 * square_m_);
      const double weight = std::exp(-d.dot(d) / 2);
      sum += weight * misses_[i];
      total += weight;
    }
    return sum / total;
  }

  double square_m_;
  cv::Matx33d h_, board_from_image_;
  std::vector<cv::Point2d> places_, misses_;
  bool found_ = false;
};

/// Shortest side of a square at a corner, in the photograph [px].
double SquareSize(const BoardMap& map, const BoardLayout& board, const Eigen::Vector3d& at) {
  const double half = board.square_m / 2;
  const cv::Point2d right = map({at.x() + half, at.y()}) - map({at.x() - half, at.y()}),
                    up = map({at.x(), at.y() + half}) - map({at.x(), at.y() - half});
  // Height of the parallelogram over its longer side: the size of a square in a low view.
  return std::abs(right.cross(up)) / std::max({cv::norm(right), cv::norm(up), 1e-9});
}

/// The print at a position of the board.
class BoardInk {
 public:
  explicit BoardInk(const BoardPattern& pattern)
      : board_(pattern.layout), first_white_(pattern.first_white) {
    for (int marker = 0; marker < pattern.MarkerCount(); ++marker)
      markers_.push_back(MarkerInk(pattern.dictionary, marker));
  }
  /// 1 on ink, 0 on paper.
  double At(const cv::Point2d& p) const {
    const double x = (p.x + board_.Width() / 2) / board_.square_m,
                 y = (board_.Height() / 2 - p.y) / board_.square_m;
    const int column = static_cast<int>(std::floor(x)), row = static_cast<int>(std::floor(y));
    if (column < 0 || row < 0 || column >= board_.columns || row >= board_.rows) return 0;
    if ((row + column + first_white_) % 2 == 0) return 1;
    const auto& ink = markers_[(row * board_.columns + column) / 2];
    const double share = board_.marker_m / board_.square_m, cells = static_cast<double>(ink.size());
    const double u = (x - column - (1 - share) / 2) / share * cells,
                 v = (y - row - (1 - share) / 2) / share * cells;
    if (u < 0 || v < 0 || u >= cells || v >= cells) return 0;
    return ink[v][u];
  }

 private:
  const BoardLayout& board_;
  bool first_white_;
  std::vector<std::vector<std::vector<int>>> markers_;
};

/// The expected picture of the board around one corner, and the pixels that it covers.
struct Patch {
  cv::Mat expected;  // 32F, 0 on paper and 1 on ink
  cv::Mat inside;    // 8U, pixels that are used
  cv::Point origin;  // in the photograph
};

/// The four half squares that meet in a corner.
Patch ExpectedPatch(const cv::Mat& grey, const BoardMap& map, const BoardInk& ink,
                    const BoardLayout& board, const cv::Point2d& at) {
  constexpr double kReach = 0.5;  // squares
  constexpr double kBlur_px = 0.7;
  constexpr int kRim = 3, kSamples = 16;
  const double reach = kReach * board.square_m;
  std::vector<cv::Point2f> on_board, seen;
  for (const auto& [dx, dy] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
    const cv::Point2d corner(at.x + dx * reach, at.y + dy * reach);
    on_board.emplace_back((corner - at) / reach);
    seen.emplace_back(map(corner));
  }
  const cv::Rect box = cv::boundingRect(seen);
  Patch patch;
  patch.origin = box.tl() - cv::Point(kRim, kRim);
  const cv::Rect whole(patch.origin, box.size() + cv::Size(2 * kRim, 2 * kRim));
  if ((whole & cv::Rect(0, 0, grey.cols, grey.rows)) != whole) return {};
  for (cv::Point2f& p : seen) p -= cv::Point2f(patch.origin);
  const cv::Mat back = cv::getPerspectiveTransform(seen, on_board);
  const cv::Matx33d board_from_patch(back.ptr<double>());
  patch.expected.create(whole.size(), CV_32F);
  patch.inside.create(whole.size(), CV_8U);
  for (int y = 0; y < whole.height; ++y)
    for (int x = 0; x < whole.width; ++x) {
      double sum = 0;
      for (int k = 0; k < kSamples; ++k) {
        // No two samples in the same row or column, so that an edge along the pixel grid is also
        // accurate to a sixteenth.
        const cv::Point2d sub(x + (k + 0.5) / kSamples - 0.5,
                              y + (7 * k % kSamples + 0.5) / kSamples - 0.5);
        sum += ink.At(at + reach * Map(board_from_patch, sub));
      }
      patch.expected.at<float>(y, x) = static_cast<float>(sum / kSamples);
      const cv::Point2d q = Map(board_from_patch, cv::Point2d(x, y));
      patch.inside.at<std::uint8_t>(y, x) = std::abs(q.x) < 1 && std::abs(q.y) < 1;
    }
  cv::GaussianBlur(patch.expected, patch.expected, {0, 0}, kBlur_px);
  return patch;
}

struct Fit {
  cv::Point2d offset;
  double correlation = 0;
};

/// Of two pictures' levels, pixel by pixel.
struct GreySums {
  double count = 0, st = 0, ss = 0, tt = 0, s1 = 0, t1 = 0;

  void Add(double s, double t) {
    count += 1;
    s1 += s;
    t1 += t;
    ss += s * s;
    tt += t * t;
    st += s * t;
  }
  double Variance() const { return (ss - s1 * s1 / count) * (tt - t1 * t1 / count); }
  double Covariance() const { return st - s1 * t1 / count; }
};

/// Position of the patch in the photograph, by Gauss-Newton over shift, brightness and contrast.
Fit FitPatch(const cv::Mat& grey, const Patch& patch, double most_px) {
  Fit fit;
  cv::Mat dx, dy;
  cv::Sobel(patch.expected, dx, CV_32F, 1, 0, 3, 1.0 / 8);
  cv::Sobel(patch.expected, dy, CV_32F, 0, 1, 3, 1.0 / 8);
  for (int round = 0; round < 12; ++round) {
    cv::Mat shown;
    const cv::Point2d middle(patch.origin.x + fit.offset.x + (patch.expected.cols - 1) / 2.0,
                             patch.origin.y + fit.offset.y + (patch.expected.rows - 1) / 2.0);
    cv::getRectSubPix(grey, patch.expected.size(), middle, shown, CV_32F);
    // shown = a + b expected - b (gradient . d)
    cv::Matx44d normal = cv::Matx44d::zeros();
    cv::Vec4d right(0, 0, 0, 0);
    GreySums sums;
    for (int y = 0; y < shown.rows; ++y)
      for (int x = 0; x < shown.cols; ++x) {
        if (!patch.inside.at<std::uint8_t>(y, x)) continue;
        const double t = patch.expected.at<float>(y, x), s = shown.at<float>(y, x);
        const cv::Vec4d row(1, t, dx.at<float>(y, x), dy.at<float>(y, x));
        normal += row * row.t();
        right += s * row;
        sums.Add(s, t);
      }
    const double variance = sums.Variance();
    fit.correlation = variance > 0 ? -sums.Covariance() / std::sqrt(variance) : 0;
    bool solved = false;
    const cv::Matx44d inverse = normal.inv(cv::DECOMP_CHOLESKY, &solved);
    if (!solved) return {};
    const cv::Vec4d x = inverse * right;
    if (x[1] > -BoardDetectionTuning::kContrast) return {};  // ink must be darker than paper
    // The photograph shows expected(p - d) = expected - gradient . d.
    const cv::Point2d step(-x[2] / x[1], -x[3] / x[1]);
    fit.offset += step;
    if (!(cv::norm(fit.offset) <= most_px)) return {};
    if (cv::norm(step) < 1e-3) break;
  }
  return fit;
}

/// All corners that match the photograph at their predicted positions.
std::vector<BoardCorner> FitCorners(const cv::Mat& grey, const BoardMap& map, const BoardInk& ink,
                                    const BoardLayout& board) {
  std::vector<BoardCorner> corners;
  for (int id = 0; id < board.CornerCount(); ++id) {
    const Eigen::Vector3d at = board.Corner(id);
    const double size = SquareSize(map, board, at);
    if (size < kLeastSquare_px) continue;
    const Patch patch = ExpectedPatch(grey, map, ink, board, {at.x(), at.y()});
    if (patch.expected.empty()) continue;
    const Fit fit = FitPatch(grey, patch, std::max(2.0, 0.15 * size));
    if (fit.correlation < BoardDetectionTuning::kCorrelation) continue;
    const cv::Point2d pixel = map({at.x(), at.y()}) + fit.offset;
    corners.push_back({id, Eigen::Vector2d(pixel.x + 0.5, pixel.y + 0.5)});
  }
  return corners;
}

MarkerPoints PointsOf(const std::vector<BoardCorner>& corners, const BoardLayout& board) {
  MarkerPoints points;
  for (const BoardCorner& corner : corners) {
    const Eigen::Vector3d at = board.Corner(corner.id);
    points.board.emplace_back(at.x(), at.y());
    points.image.emplace_back(corner.pixel.x() - 0.5, corner.pixel.y() - 0.5);
  }
  return points;
}

constexpr int kMostSteps = 5;
constexpr double kLeastShare = 0.3, kMostShare = 0.98;  // of a square that its marker takes

/// How well corners of the board look as they would with markers of this share of a square: the sum
/// of their correlations.
double Explained(const cv::Mat& grey, const BoardMap& map, BoardPattern pattern, double share) {
  constexpr int kSome = 30;  // corners that are looked at
  BoardLayout& board = pattern.layout;
  board.marker_m = std::clamp(share, kLeastShare, kMostShare) * board.square_m;
  const BoardInk ink(pattern);
  double sum = 0;
  for (int id = 0; id < board.CornerCount(); id += 1 + board.CornerCount() / kSome) {
    const Eigen::Vector3d at = board.Corner(id);
    const double size = SquareSize(map, board, at);
    if (size < kLeastSquare_px) continue;
    const Patch patch = ExpectedPatch(grey, map, ink, board, {at.x(), at.y()});
    if (!patch.expected.empty())
      sum += FitPatch(grey, patch, std::max(2.0, 0.15 * size)).correlation;
  }
  return sum;
}

/// Share of ink in each pixel of the reduced photograph; negative outside of the board and its rim
/// of half a square.
cv::Mat InkOf(const cv::Size& size, double factor, const BoardMap& map,
              const BoardPattern& pattern) {
  constexpr int kSamples = 16;
  const BoardLayout& board = pattern.layout;
  const BoardInk ink(pattern);
  const double width = board.Width() / 2 + board.square_m / 2,
               height = board.Height() / 2 + board.square_m / 2;
  cv::Mat share(size, CV_32F, cv::Scalar(-1));
  for (int y = 0; y < size.height; ++y)
    for (int x = 0; x < size.width; ++x) {
      const auto at = [&](double dx, double dy) {
        return map.OnBoard({(x + dx) / factor - 0.5, (y + dy) / factor - 0.5});
      };
      const cv::Point2d middle = at(0.5, 0.5);
      if (std::abs(middle.x) > width || std::abs(middle.y) > height) continue;
      const cv::Point2d right = at(1, 0.5) - at(0, 0.5), down = at(0.5, 1) - at(0.5, 0);
      double sum = 0;
      for (int k = 0; k < kSamples; ++k)
        sum += ink.At(middle + ((k + 0.5) / kSamples - 0.5) * right +
                      ((7 * k % kSamples + 0.5) / kSamples - 0.5) * down);
      const double dark = sum / kSamples;
      share.at<float>(y, x) = static_cast<float>(pattern.inverted ? 1 - dark : dark);
    }
  return share;
}

/// Medians of the pixels under a mask, by channel.
cv::Vec3f MedianColor(const cv::Mat& image, const cv::Mat& mask) {
  cv::Vec3f median(0, 0, 0);
  for (int c = 0; c < 3; ++c) {
    std::vector<float> values;
    for (int y = 0; y < image.rows; ++y)
      for (int x = 0; x < image.cols; ++x)
        if (mask.at<std::uint8_t>(y, x)) values.push_back(image.at<cv::Vec3f>(y, x)[c]);
    if (values.empty()) return median;
    median[c] = UpperMedian(std::move(values));
  }
  return median;
}

/// Pixels next to detected corners, where nothing can be in front of the board.
cv::Mat NextToCorners(const cv::Size& size, const std::vector<BoardCorner>& corners, double factor,
                      const BoardMap& map, const BoardLayout& board) {
  cv::Mat near(size, CV_8U, cv::Scalar(0));
  for (const BoardCorner& corner : corners) {
    const Eigen::Vector3d at = board.Corner(corner.id);
    std::vector<cv::Point> outline;
    for (const auto& [dx, dy] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
      const cv::Point2d p =
          map({at.x() + 0.5 * dx * board.square_m, at.y() + 0.5 * dy * board.square_m});
      outline.emplace_back(static_cast<int>(std::lround((p.x + 0.5) * factor - 0.5)),
                           static_cast<int>(std::lround((p.y + 0.5) * factor - 0.5)));
    }
    cv::fillConvexPoly(near, outline, cv::Scalar(255));
  }
  return near;
}

/// The light on each pixel's neighbourhood, relative to that of `paper` and `ink`: the factor by
/// which the print explains a window around it best. Negative where the print is not in the window,
/// or black.
cv::Mat LightOf(const cv::Mat& rgb, const cv::Mat& ink, const cv::Vec3f& paper,
                const cv::Vec3f& black, int window) {
  cv::Mat product(rgb.size(), CV_32F, cv::Scalar(0)), square = product.clone();
  for (int y = 0; y < rgb.rows; ++y)
    for (int x = 0; x < rgb.cols; ++x) {
      const float share = ink.at<float>(y, x);
      if (share < 0) continue;
      const cv::Vec3f e = (1 - share) * paper + share * black;
      product.at<float>(y, x) = e.dot(rgb.at<cv::Vec3f>(y, x));
      square.at<float>(y, x) = e.dot(e);
    }
  cv::boxFilter(product, product, CV_32F, {window, window}, {-1, -1}, false);
  cv::boxFilter(square, square, CV_32F, {window, window}, {-1, -1}, false);
  cv::Mat light(rgb.size(), CV_32F, cv::Scalar(-1));
  for (int y = 0; y < rgb.rows; ++y)
    for (int x = 0; x < rgb.cols; ++x)
      if (square.at<float>(y, x) > 1)
        light.at<float>(y, x) =
            std::clamp(product.at<float>(y, x) / square.at<float>(y, x), 0.35F, 1.15F);
  return light;
}

/// Distance of a colour to those between two others.
float DistanceToSegment(const cv::Vec3f& color, const cv::Vec3f& a, const cv::Vec3f& b) {
  const cv::Vec3f along = b - a;
  const float square = along.dot(along);
  const float t = square > 0 ? std::clamp((color - a).dot(along) / square, 0.0F, 1.0F) : 0.0F;
  return static_cast<float>(cv::norm(color - a - t * along));
}

/// Colour distance of each pixel to the print under the light of its neighbourhood.
///
/// At the edges of squares and of their markers blur and the tenths of a pixel by which the print
/// is misplaced make any colour between paper and ink, so that all that lies between the lightest
/// and the darkest print next to the pixel is allowed. The light is also taken from windows to its
/// sides: next to the figure one of them has nothing of it.
cv::Mat DistanceToPrint(const cv::Mat& rgb, const cv::Mat& ink, const cv::Vec3f& paper,
                        const cv::Vec3f& black) {
  constexpr int kWindow = 7, kAside = 4;
  const cv::Mat light = LightOf(rgb, ink, paper, black, kWindow);
  cv::Mat least, most;
  cv::erode(cv::max(ink, 0.0F), least, {});
  cv::dilate(cv::max(ink, 0.0F), most, {});
  cv::Mat distance(rgb.size(), CV_32F, cv::Scalar(0));
  for (int y = 0; y < rgb.rows; ++y)
    for (int x = 0; x < rgb.cols; ++x) {
      if (ink.at<float>(y, x) < 0) continue;
      const float lightest = least.at<float>(y, x), darkest = most.at<float>(y, x);
      const cv::Vec3f a = (1 - lightest) * paper + lightest * black,
                      b = (1 - darkest) * paper + darkest * black;
      float nearest = 1e9F;
      for (const auto& [dx, dy] :
           {std::pair{0, 0}, {-kAside, 0}, {kAside, 0}, {0, -kAside}, {0, kAside}}) {
        const int u = x + dx, v = y + dy;
        if (u < 0 || v < 0 || u >= rgb.cols || v >= rgb.rows || ink.at<float>(v, u) < 0) continue;
        const float l = light.at<float>(v, u);
        nearest = std::min(nearest, DistanceToSegment(rgb.at<cv::Vec3f>(y, x), l * a, l * b));
      }
      distance.at<float>(y, x) = nearest;
    }
  cv::medianBlur(distance, distance, 3);
  return distance;
}

/// Corners that the picture shows, from points whose places on the board are known roughly.
std::vector<BoardCorner> CornersFrom(const MarkerPoints& points, const cv::Mat& grey,
                                     const BoardInk& ink, const BoardLayout& board) {
  const BoardMap rough(points, board.square_m);
  if (!rough.found()) return {};
  const std::vector<BoardCorner> first = FitCorners(grey, rough, ink, board);
  // Marker corners have errors of half a pixel, which distort the patches. The detected corners
  // give better predictions.
  const BoardMap fine(PointsOf(first, board), board.square_m);
  return fine.found() ? FitCorners(grey, fine, ink, board) : first;
}

std::vector<BoardCorner> CornersIn(const Image8& picture, const BoardPattern& pattern,
                                   bool thorough) {
  const BoardLayout& board = pattern.layout;
  const cv::Mat grey(picture.height, picture.width, CV_8UC1,
                     const_cast<std::uint8_t*>(picture.data.data()));
  const BoardInk ink(pattern);
  std::vector<BoardCorner> corners =
      CornersFrom(PlacedMarkers(picture, pattern, thorough), grey, ink, board);
  constexpr int kSmall_px = 1000;  // of a picture whose markers may be a dozen pixels
  constexpr double kEnlarged = 2.5, kEnough = 0.9;
  if (!thorough || std::max(picture.width, picture.height) > kSmall_px ||
      SizeOf(corners) >= kEnough * board.CornerCount())
    return corners;
  std::vector<BoardCorner> matched =
      CornersFrom(PointsOf(MatchPrint(picture, pattern, kEnlarged), board), grey, ink, board);
  return matched.size() > corners.size() ? matched : corners;
}

}  // namespace

std::vector<BoardCorner> FindBoard(const Image8& image, const BoardLayout& board) {
  return FindBoard(image, BoardPattern(board), false);
}

std::vector<BoardCorner> FindBoard(const Image8& image, const BoardPattern& pattern,
                                   bool thorough) {
  if (const auto problems = pattern.Problems(); !problems.empty())
    throw InputError("capture: " + problems.front());
  const Image8 grey = GreyPicture(image, pattern.inverted);
  std::vector<BoardCorner> corners = CornersIn(grey, pattern, thorough);
  if (!corners.empty() || !pattern.mirrored) return corners;
  corners = CornersIn(MirroredPicture(grey), pattern, thorough);
  for (BoardCorner& corner : corners) corner.pixel.x() = image.width - corner.pixel.x();
  return corners;
}

double MarkerShareIn(const Image8& image, const BoardPattern& pattern) {
  const Image8 picture = GreyPicture(image, pattern.inverted);
  const BoardMap map(PointsOf(CornersIn(picture, pattern, true), pattern.layout),
                     pattern.layout.square_m);
  const double start = pattern.layout.marker_m / pattern.layout.square_m;
  if (!map.found()) return 0;
  const cv::Mat grey(picture.height, picture.width, CV_8UC1,
                     const_cast<std::uint8_t*>(picture.data.data()));
  double share = start;
  for (const double step : {0.03, 0.01}) {
    std::map<int, double> explained;  // by steps from `share`
    int best = 0;
    const auto at = [&](int k) {
      const auto [known, is_new] = explained.try_emplace(k, 0);
      if (is_new) known->second = Explained(grey, map, pattern, share + k * step);
      return known->second;
    };
    for (int round = 0; round < kMostSteps && at(best) < std::max(at(best - 1), at(best + 1));
         ++round)
      best += at(best + 1) > at(best - 1) ? 1 : -1;
    const double bend = at(best - 1) - 2 * at(best) + at(best + 1);
    const double top =
        bend < 0 ? std::clamp((at(best - 1) - at(best + 1)) / (2 * bend), -0.5, 0.5) : 0;
    share = std::clamp(share + (best + top) * step, kLeastShare, kMostShare);
  }
  return share;
}

BoardOdds OddsOfBoard(const Image8& image, const std::vector<BoardCorner>& corners, double factor,
                      const BoardPattern& pattern, double limit) {
  const BoardLayout& board = pattern.layout;
  BoardOdds known;
  const BoardMap map(PointsOf(corners, board), board.square_m);
  if (!map.found()) return known;
  cv::Mat rgb;
  cv::Mat(image.height, image.width, CV_8UC3, const_cast<std::uint8_t*>(image.data.data()))
      .convertTo(rgb, CV_32FC3);
  const cv::Mat ink = InkOf(rgb.size(), factor, map, pattern),
                near = NextToCorners(rgb.size(), corners, factor, map, board);
  const cv::Vec3f paper = MedianColor(rgb, near & (ink >= 0) & (ink < 0.05)),
                  black = MedianColor(rgb, near & (ink > 0.95));
  if (!(cv::norm(paper) > cv::norm(black) + BoardDetectionTuning::kContrast)) return known;
  const cv::Mat distance = DistanceToPrint(rgb, ink, paper, black);
  known.on_board = Image8(image.width, image.height, 1);
  known.odds = ImageF(image.width, image.height, 1);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      if (ink.at<float>(y, x) < 0) continue;
      *known.on_board.at(x, y) = 255;
      *known.odds.at(x, y) = static_cast<float>(std::clamp(
          4 * (distance.at<float>(y, x) / BoardDetectionTuning::kEven - 1), -limit, limit));
    }
  return known;
}

}  // namespace keypose::capture
