#include "capture/films/view_agreement.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "capture/pictures/cv_image.h"
#include "core/numbers/parallel.h"
#include "core/values/size_of.h"

namespace keypose::capture {
namespace {

using Eigen::Vector3d;

constexpr int kCoarse = 32, kFine = 96;  // places along the longest side of the space
constexpr int kMargin = 2;               // pixels of half size: errors of masks and cameras

struct Space {
  Vector3d low, high;
};

/// A mask at half the size, 255 where any of its pixels is.
cv::Mat Halved(const Image8& mask) {
  cv::Mat small;
  cv::resize(MatOf(mask), small, {(mask.width + 1) / 2, (mask.height + 1) / 2}, 0, 0,
             cv::INTER_AREA);
  return small > 63;
}

cv::Mat Grown(const cv::Mat& mask) {
  cv::Mat wide;
  cv::dilate(mask, wide,
             cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * kMargin + 1, 2 * kMargin + 1}));
  return wide;
}

/// The pixel of a point, and half the width of `size` there [px]; false: not seen.
bool See(const View& view, const Vector3d& point, double size, cv::Point* pixel, int* reach) {
  const Vector3d x = view.camera_from_world * point;
  if (x.z() <= 0) return false;
  const Eigen::Vector2d at = view.camera.Project(x);
  if (!(at.x() >= 0 && at.y() >= 0 && at.x() < view.camera.width && at.y() < view.camera.height))
    return false;
  *pixel = {static_cast<int>(at.x()), static_cast<int>(at.y())};
  *reach = std::min(12, static_cast<int>(std::ceil(0.5 * size * view.camera.fx / x.z())));
  return true;
}

/// The point nearest to the rays through the middles of the masks' boxes, with a half width that
/// all boxes fit into.
Space SpaceOfBoxes(const std::vector<View>& views, const std::vector<cv::Mat>& unions) {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Vector3d b = Vector3d::Zero();
  for (std::size_t c = 0; c < views.size(); ++c) {
    const cv::Rect box = cv::boundingRect(unions[c]);
    const Vector3d ray =
        (views[c].camera_from_world.rotation.conjugate() *
         views[c].camera.Unproject({box.x + 0.5 * box.width, box.y + 0.5 * box.height}))
            .normalized();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
    a += across;
    b += across * views[c].Center();
  }
  const Vector3d middle = a.ldlt().solve(b);
  double half = 0;
  for (std::size_t c = 0; c < views.size(); ++c) {
    const cv::Rect box = cv::boundingRect(unions[c]);
    const double depth = (views[c].camera_from_world * middle).z();
    half = std::max(half, 0.75 * std::max(box.width, box.height) * depth / views[c].camera.fx);
  }
  return {middle - Vector3d::Constant(half), middle + Vector3d::Constant(half)};
}

/// Calls body(point) for the middles of cells along the space.
template <class Body>
void ForPlaces(const Space& space, double cell, const Body& body) {
  for (double z = space.low.z() + cell / 2; z < space.high.z(); z += cell)
    for (double y = space.low.y() + cell / 2; y < space.high.y(); y += cell)
      for (double x = space.low.x() + cell / 2; x < space.high.x(); x += cell)
        body(Vector3d(x, y, z));
}

/// Whether at most `denials` cameras see a place outside of their masks.
bool Meet(const std::vector<View>& views, const std::vector<cv::Mat>& masks, const Vector3d& point,
          double cell, int denials) {
  int seen = 0;
  for (std::size_t c = 0; c < views.size(); ++c) {
    cv::Point pixel;
    int reach = 0;
    if (!See(views[c], point, cell, &pixel, &reach)) continue;
    ++seen;
    const cv::Rect window =
        cv::Rect(pixel.x - reach, pixel.y - reach, 2 * reach + 1, 2 * reach + 1) &
        cv::Rect({0, 0}, masks[c].size());
    if (cv::countNonZero(masks[c](window)) == 0 && --denials < 0) return false;
  }
  return seen >= 2;
}

/// The part of the space in which the masks meet, looked for with large cells.
Space Met(const std::vector<View>& views, const std::vector<cv::Mat>& unions, const Space& space) {
  const double cell = (space.high - space.low).maxCoeff() / kCoarse;
  Space met{space.high, space.low};
  ForPlaces(space, cell, [&](const Vector3d& point) {
    if (!Meet(views, unions, point, cell, 1)) return;
    met.low = met.low.cwiseMin(point - Vector3d::Constant(cell));
    met.high = met.high.cwiseMax(point + Vector3d::Constant(cell));
  });
  return met;
}

}  // namespace

ViewAgreement::ViewAgreement(const std::vector<View>& views, const std::vector<Image8>& unions)
    : views_(views), pixels_(views.size()), reach_(views.size()) {
  std::vector<cv::Mat> small;
  for (std::size_t c = 0; c < views.size(); ++c) {
    widths_.push_back(unions[c].width);
    heights_.push_back(unions[c].height);
    small.push_back(Halved(unions[c]));
    views_[c].camera = views[c].camera.Scaled(0.5);
    views_[c].camera.width = small[c].cols;
    views_[c].camera.height = small[c].rows;
  }
  const Space space = Met(views_, small, SpaceOfBoxes(views_, small));
  if (!((space.high - space.low).minCoeff() > 0)) return;
  const double cell = (space.high - space.low).maxCoeff() / kFine;
  ForPlaces(space, cell, [&](const Vector3d& point) {
    ++places_;
    for (std::size_t c = 0; c < views_.size(); ++c) {
      cv::Point pixel;
      int reach = 0;
      const bool seen = See(views_[c], point, cell, &pixel, &reach);
      pixels_[c].push_back(seen ? pixel.y * small[c].cols + pixel.x : -1);
      reach_[c].push_back(static_cast<std::uint8_t>(reach));
    }
  });
}

std::vector<Image8> ViewAgreement::LeastDenials(const std::vector<Image8>& masks) const {
  std::vector<cv::Mat> wide, least;
  for (const Image8& mask : masks) {
    wide.push_back(Grown(Halved(mask)));
    least.emplace_back(wide.back().size(), CV_8U, cv::Scalar(kMostDenials));
  }
  for (std::size_t place = 0; place < places_; ++place) {
    int denials = 0, seen = 0;
    std::array<char, 64> denied{};
    for (std::size_t c = 0; c < masks.size(); ++c) {
      if (pixels_[c][place] < 0) continue;
      ++seen;
      denied[c % 64] = wide[c].data[pixels_[c][place]] == 0;
      denials += denied[c % 64];
    }
    if (seen < 3 || denials > kMostDenials) continue;
    for (std::size_t c = 0; c < masks.size(); ++c) {
      const int others = denials - denied[c % 64];
      if (pixels_[c][place] < 0 || others >= kMostDenials) continue;
      const int width = wide[c].cols, reach = reach_[c][place], px = pixels_[c][place] % width,
                py = pixels_[c][place] / width;
      for (int y = std::max(0, py - reach); y <= std::min(wide[c].rows - 1, py + reach); ++y)
        for (int x = std::max(0, px - reach); x <= std::min(width - 1, px + reach); ++x) {
          std::uint8_t& value = least[c].at<std::uint8_t>(y, x);
          value = std::min(value, static_cast<std::uint8_t>(others));
        }
    }
  }
  std::vector<Image8> full;
  for (std::size_t c = 0; c < masks.size(); ++c) {
    cv::Mat large;
    cv::resize(least[c], large, {widths_[c], heights_[c]}, 0, 0, cv::INTER_NEAREST);
    full.push_back(ImageOf(large));
  }
  return full;
}

std::vector<float> OddsOfDenials(const std::vector<Image8>& masks,
                                 const std::vector<Image8>& denials, const Image8& area,
                                 double limit) {
  constexpr float kOneMayErr = -0.3F;  // a camera alone may have lost a limb
  std::array<std::array<double, kMostDenials + 1>, 2> count{};  // of the set, of the actor
  std::array<double, 2> all{};
  for (std::size_t k = 0; k < masks.size(); ++k)
    for (std::size_t p = 0; p < masks[k].data.size(); ++p) {
      if (!area.data[p]) continue;
      const bool actor = masks[k].data[p] > 127;
      count[actor][denials[k].data[p]] += 1;
      all[actor] += 1;
    }
  std::vector<float> odds;
  for (std::size_t d = 0; d <= kMostDenials; ++d) {
    const double of_actor = (count[1][d] + 1) / (all[1] + 1),
                 of_set = (count[0][d] + 1) / (all[0] + 1);
    odds.push_back(static_cast<float>(std::clamp(std::log(of_actor / of_set), -limit, limit)));
  }
  odds[1] = std::max(odds[1], kOneMayErr);
  for (std::size_t d = 1; d <= kMostDenials; ++d) odds[d] = std::min(odds[d], odds[d - 1]);
  return odds;
}

}  // namespace keypose::capture
