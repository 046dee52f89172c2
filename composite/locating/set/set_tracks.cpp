#include "composite/locating/set/set_tracks.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::composite {
namespace {

// Chosen on the clay creature's film of seed 1 (synth) with a camera that swings and draws nearer.
struct SetTracksTuning {
  // round the character [longer side]: its shadow's edge, soft mattes
  KEYPOSE_TUNED(double, kRoom, 0.008);
  KEYPOSE_TUNED(int, kCell, 40);              // px of a picture of 960
  KEYPOSE_TUNED(int, kInACell, 3);            // places
  KEYPOSE_TUNED(int, kWindow, 31);            // px that are followed together
  KEYPOSE_TUNED(int, kHalvings, 4);           // of the picture, the smallest first
  KEYPOSE_TUNED(double, kAround, 24);         // px: detail is what differs from this neighbourhood
  KEYPOSE_TUNED(double, kLevels, 40);         // grey levels that its contrast is brought to
  KEYPOSE_TUNED(double, kLeastContrast, 2);   // grey levels, below which it is not
  KEYPOSE_TUNED(double, kGrain, 2);           // px: deviation of the filter against it
  KEYPOSE_TUNED(double, kLeastLevels, 0.1);   // grey levels by which a place differs from others
  KEYPOSE_TUNED(int, kLongest, 48);           // pictures that a place is followed over
  KEYPOSE_TUNED(double, kReturns, 3);         // deviations: followed there and back it ends so near
  KEYPOSE_TUNED(double, kLeastGrain, 0.05);   // squared grey levels
  KEYPOSE_TUNED(double, kOfDirection, 1e-3);  // squared error of a slope's direction [rad]
  KEYPOSE_TUNED(double, kBest, 0.1);          // px: no place is known better
};

constexpr double kCellSide = 960;       // px
constexpr int kBorder = 18;             // px
constexpr double kOfRounding = 0.0157;  // squared slope of whole grey levels, by 3 x 3 pixels

/// Neighbouring pixels have one error: so many count as one.
double Correlated() { return 4 * 3.14159 * SetTracksTuning::kGrain * SetTracksTuning::kGrain; }

/// 255 where the set is, away from the character.
cv::Mat SetMask(const SetPicture& picture) {
  cv::Mat mask(picture.picture->height, picture.picture->width, CV_8U, cv::Scalar(255));
  if (picture.figure && !picture.figure->empty()) {
    const cv::Mat figure(picture.figure->height, picture.figure->width, CV_8U,
                         const_cast<std::uint8_t*>(picture.figure->data.data()));
    const int room = std::max(
        3, static_cast<int>(std::lround(SetTracksTuning::kRoom * std::max(mask.cols, mask.rows))));
    cv::Mat wide;
    cv::dilate(figure > 127, wide,
               cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * room + 1, 2 * room + 1}));
    mask.setTo(0, wide);
  }
  cv::rectangle(mask, {0, 0, mask.cols, mask.rows}, cv::Scalar(0), 2 * kBorder);
  return mask;
}

/// Grey values without most of the grain, relative to those around, so that wood and walls of
/// little contrast do not drown in the rounding to 8 bits.
cv::Mat DetailOf(const Image8& picture) {
  const cv::Mat pixels(picture.height, picture.width, CV_8UC(picture.channels),
                       const_cast<std::uint8_t*>(picture.data.data()));
  cv::Mat grey, smooth, around, detail;
  if (picture.channels == 1)
    grey = pixels;
  else
    cv::cvtColor(pixels, grey, cv::COLOR_RGB2GRAY);
  grey.convertTo(grey, CV_32F);
  cv::GaussianBlur(grey, smooth, {0, 0}, SetTracksTuning::kGrain);
  cv::GaussianBlur(grey, around, {0, 0}, SetTracksTuning::kAround);
  const cv::Mat above = smooth - around;
  cv::Mat contrast;
  cv::GaussianBlur(above.mul(above), contrast, {0, 0}, SetTracksTuning::kAround);
  cv::sqrt(contrast + SetTracksTuning::kLeastContrast * SetTracksTuning::kLeastContrast, contrast);
  cv::Mat(SetTracksTuning::kLevels * above / contrast + 128).convertTo(detail, CV_8U);
  return detail;
}

struct Followed {
  SetTrack track;
  cv::Point2f at;
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // of all steps
  bool lost = false, ended = false;
};

/// The products of grey levels' slopes at each pixel, summed over a window.
class Slopes {
 public:
  explicit Slopes(const cv::Mat& grey) {
    cv::Mat x, y;
    cv::Sobel(grey, x, CV_32F, 1, 0, 3, 0.125);
    cv::Sobel(grey, y, CV_32F, 0, 1, 3, 0.125);
    for (const auto& [sum, product] :
         {std::pair(&xx_, cv::Mat(x.mul(x))), std::pair(&xy_, cv::Mat(x.mul(y))),
          std::pair(&yy_, cv::Mat(y.mul(y)))})
      cv::boxFilter(product, *sum, CV_32F, {SetTracksTuning::kWindow, SetTracksTuning::kWindow},
                    {-1, -1}, false, cv::BORDER_REPLICATE);
  }
  Eigen::Matrix2d At(const cv::Point2f& at) const {
    const int x = std::clamp(static_cast<int>(std::lround(at.x)), 0, xx_.cols - 1);
    const int y = std::clamp(static_cast<int>(std::lround(at.y)), 0, xx_.rows - 1);
    Eigen::Matrix2d sum;
    sum << xx_.at<float>(y, x), xy_.at<float>(y, x), xy_.at<float>(y, x), yy_.at<float>(y, x);
    return sum;
  }
  /// How much there is to follow: all slopes, with those of the better direction counted little.
  cv::Mat Strength() const {
    cv::Mat root, difference = xx_ - yy_;
    cv::sqrt(difference.mul(difference) + 4 * xy_.mul(xy_), root);
    return xx_ + yy_ - 0.9 * root;
  }

 private:
  cv::Mat xx_, xy_, yy_;
};

/// How uncertain a step from one picture to the next is, by the slopes, less what grain alone would
/// have: that has slopes as well, which say nothing.
/// @param levels  that the window differs by from where it was before [mean]
Eigen::Matrix2d CovarianceOf(const Eigen::Matrix2d& slopes, double levels) {
  const double squared = std::max(SetTracksTuning::kLeastGrain, 1.5 * levels * levels);
  const double of_grain =
      SetTracksTuning::kWindow * SetTracksTuning::kWindow *
      (squared / (4 * SetTracksTuning::kGrain * SetTracksTuning::kGrain) + kOfRounding);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> parts(slopes);
  const double of_direction = SetTracksTuning::kOfDirection * parts.eigenvalues()[1];
  const Eigen::Vector2d left =
      (parts.eigenvalues().array() - of_grain - of_direction).max(1e-6 * of_grain);
  const Eigen::Vector2d variance =
      (Correlated() * squared / left.array() + SetTracksTuning::kBest * SetTracksTuning::kBest)
          .matrix();
  return parts.eigenvectors() * variance.asDiagonal() * parts.eigenvectors().transpose();
}

class Follower {
 public:
  void Look(const SetPicture& picture, int index) {
    const cv::Mat mask = SetMask(picture), grey = DetailOf(*picture.picture);
    const Slopes slopes(grey);
    std::vector<cv::Mat> pyramid;
    cv::buildOpticalFlowPyramid(grey, pyramid, {SetTracksTuning::kWindow, SetTracksTuning::kWindow},
                                SetTracksTuning::kHalvings);
    if (index > 0) Follow(pyramid, slopes, mask, index);
    AddPlaces(slopes, mask, index);
    before_ = pyramid;
  }
  std::vector<SetTrack> Tracks() const {
    std::vector<SetTrack> tracks;
    for (const Followed& followed : followed_)
      if (followed.track.size() >= 2) tracks.push_back(followed.track);
    return tracks;
  }

 private:
  void Follow(const std::vector<cv::Mat>& pyramid, const Slopes& slopes, const cv::Mat& mask,
              int index) {
    std::vector<int> alive;
    std::vector<cv::Point2f> from, to, back;
    for (int i = 0; i < SizeOf(followed_); ++i)
      if (IsAlive(followed_[i])) {
        alive.push_back(i);
        from.push_back(followed_[i].at);
      }
    if (from.empty()) return;
    std::vector<std::uint8_t> found, found_back;
    std::vector<float> errors, errors_back;
    const auto flow = [](const auto& a, const auto& b, const auto& start, auto& end, auto& status,
                         auto& error) {
      const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 40, 0.003);
      cv::calcOpticalFlowPyrLK(a, b, start, end, status, error,
                               {SetTracksTuning::kWindow, SetTracksTuning::kWindow},
                               SetTracksTuning::kHalvings, until, 0, 1e-7);
    };
    flow(before_, pyramid, from, to, found, errors);
    flow(pyramid, before_, to, back, found_back, errors_back);
    for (int k = 0; k < SizeOf(alive); ++k) {
      Followed& followed = followed_[alive[k]];
      const Eigen::Matrix2d covariance = CovarianceOf(slopes.At(to[k]), errors[k]);
      const Eigen::Vector2d off(back[k].x - from[k].x, back[k].y - from[k].y);
      followed.lost = !found[k] || !found_back[k] || !IsOnSet(mask, to[k]) ||
                      off.dot(covariance.inverse() * off) >
                          SetTracksTuning::kReturns * SetTracksTuning::kReturns;
      if (followed.lost) continue;
      followed.at = to[k];
      // Each step adds its error to those before.
      if (followed.track.size() == 1) followed.track[0].information = covariance.inverse();
      followed.covariance += covariance;
      followed.track.push_back(
          {index, {to[k].x + 0.5, to[k].y + 0.5}, followed.covariance.inverse()});
      followed.ended = SizeOf(followed.track) >= LongestOf(alive[k]);
    }
  }
  static bool IsAlive(const Followed& followed) { return !followed.lost && !followed.ended; }
  /// A long film's tracks end here and there, and their places begin anew: errors add up, and what
  /// ties cameras together costs the square of a track's length.
  static int LongestOf(int track) {
    return SetTracksTuning::kLongest / 2 + track * 7 % (SetTracksTuning::kLongest / 2);
  }
  static bool IsOnSet(const cv::Mat& mask, const cv::Point2f& at) {
    const int x = static_cast<int>(std::lround(at.x)), y = static_cast<int>(std::lround(at.y));
    return x >= 0 && y >= 0 && x < mask.cols && y < mask.rows && mask.at<std::uint8_t>(y, x) > 0;
  }

  /// So that each cell of the picture has some, also where all are weak.
  void AddPlaces(const Slopes& slopes, const cv::Mat& mask, int index) {
    const cv::Mat strength = slopes.Strength();
    const int cell =
        std::max(8, static_cast<int>(std::lround(SetTracksTuning::kCell *
                                                 std::max(mask.cols, mask.rows) / kCellSide)));
    const int columns = (mask.cols + cell - 1) / cell, rows = (mask.rows + cell - 1) / cell;
    cv::Mat free = mask.clone();
    std::vector<int> filled(static_cast<std::size_t>(columns) * rows, 0);
    const auto take = [&](const cv::Point2f& at) {
      cv::circle(free, at, cell / 4, cv::Scalar(0), -1);
      ++filled[static_cast<int>(at.y) / cell * columns + static_cast<int>(at.x) / cell];
    };
    for (const Followed& followed : followed_)
      if (IsAlive(followed)) take(followed.at);
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column)
        while (filled[row * columns + column] < SetTracksTuning::kInACell) {
          const cv::Rect box = cv::Rect(column * cell, row * cell, cell, cell) &
                               cv::Rect(0, 0, mask.cols, mask.rows);
          double best = 0;
          cv::Point at;
          cv::minMaxLoc(strength(box), nullptr, &best, nullptr, &at, free(box));
          // A slope over the filter's width makes this difference of levels.
          const double levels = std::sqrt(std::max(0.0, best)) / SetTracksTuning::kWindow * 2 *
                                SetTracksTuning::kGrain;
          if (levels < SetTracksTuning::kLeastLevels) break;
          const cv::Point2f pixel(static_cast<float>(at.x + box.x),
                                  static_cast<float>(at.y + box.y));
          take(pixel);
          followed_.push_back({{{index, {pixel.x + 0.5, pixel.y + 0.5}}}, pixel});
        }
  }

  std::vector<Followed> followed_;
  std::vector<cv::Mat> before_;
};

}  // namespace

std::vector<SetTrack> FindSetTracks(const std::vector<SetPicture>& pictures, Progress* progress) {
  Follower follower;
  for (int i = 0; i < SizeOf(pictures); ++i) {
    ReportProgress(progress, static_cast<double>(i) / SizeOf(pictures), "following the set");
    follower.Look(pictures[i], i);
  }
  return follower.Tracks();
}

}  // namespace keypose::composite
