#include "capture/room/hidden_parts.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "capture/pictures/cv_image.h"
#include "core/numbers/parallel.h"

namespace keypose::capture {
namespace {

constexpr int kWidth = 320;        // of the pictures
constexpr double kNearer = 3;      // spacings: what touches the figure does not hide it
constexpr int kGap = 2, kRim = 2;  // px: between points of one surface, and of what is not sure

/// The least depth of points at each pixel; infinite where there is none.
cv::Mat1f NearestDepths(const View& view, const std::vector<Eigen::Vector3d>& points,
                        double spacing) {
  cv::Mat1f depths(view.camera.height, view.camera.width, std::numeric_limits<float>::infinity());
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d x = view.camera_from_world * point;
    if (x.z() <= 0) continue;
    const Eigen::Vector2d p = view.camera.Project(x);
    const double half = 0.5 * spacing * view.camera.fx / x.z();
    const cv::Rect cell = cv::Rect(cv::Point(static_cast<int>(std::floor(p.x() - half)),
                                             static_cast<int>(std::floor(p.y() - half))),
                                   cv::Point(static_cast<int>(std::ceil(p.x() + half)),
                                             static_cast<int>(std::ceil(p.y() + half)))) &
                          cv::Rect(0, 0, depths.cols, depths.rows);
    if (cell.empty()) continue;
    cv::Mat1f at = depths(cell);
    cv::min(at, static_cast<float>(x.z()), at);
  }
  return depths;
}

HiddenPart HiddenIn(View view, const StandingFigure& figure) {
  view.camera = view.camera.Scaled(static_cast<double>(kWidth) / view.camera.width);
  const cv::Mat1f of_figure = NearestDepths(view, figure.points, figure.spacing),
                  of_others = NearestDepths(view, figure.others, figure.spacing);
  constexpr float kFar = std::numeric_limits<float>::max();
  const cv::Mat1b shown = of_figure < kFar;
  cv::Mat1b hidden = (of_others + static_cast<float>(kNearer * figure.spacing) < of_figure) & shown;
  const auto disc = [](int radius) {
    return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1});
  };
  cv::morphologyEx(hidden, hidden, cv::MORPH_CLOSE, disc(kGap));
  cv::morphologyEx(hidden, hidden, cv::MORPH_OPEN, disc(1));
  HiddenPart part{
      Image8(hidden.cols, hidden.rows, 1, 0),
      static_cast<double>(cv::countNonZero(hidden)) / std::max(1, cv::countNonZero(shown))};
  cv::Mat where = MatOf(part.where);
  cv::dilate(hidden, where, disc(kRim));
  return part;
}

}  // namespace

std::vector<HiddenPart> HiddenParts(const std::vector<View>& views, const StandingFigure& figure) {
  std::vector<HiddenPart> parts(views.size());
  ParallelFor(std::ssize(views), [&](std::int64_t v) {
    parts[static_cast<std::size_t>(v)] = HiddenIn(views[static_cast<std::size_t>(v)], figure);
  });
  return parts;
}

}  // namespace keypose::capture
