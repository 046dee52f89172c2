#include "capture/agreement/view_colours.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::capture {
namespace {

constexpr int kLeastViews = 4;  // fewer have no majority

// No record of the data. Sensitivity: docs/results/sensitivity.md.
struct ViewColorTuning {
  KEYPOSE_TUNED(double, kLeastCosine, 0.4);  // of the normal and the line of sight
  // voxels behind the nearest point, up to which a point is seen
  KEYPOSE_TUNED(double, kSlack, 2.5);
  KEYPOSE_TUNED(int, kWindow, 5);    // pixels in each direction over which colours are averaged
  KEYPOSE_TUNED(double, kDark, 25);  // grey levels: colours up to this have no hue
};

/// Mean colours of the figure, without its border.
struct MaskedPicture {
  cv::Mat mean, inside;
};

MaskedPicture PictureOf(const Image8& image, const Image8& mask) {
  const cv::Mat rgb(image.height, image.width, CV_8UC3,
                    const_cast<std::uint8_t*>(image.data.data()));
  const cv::Mat figure(mask.height, mask.width, CV_8UC1,
                       const_cast<std::uint8_t*>(mask.data.data()));
  MaskedPicture picture;
  cv::blur(rgb, picture.mean, {ViewColorTuning::kWindow, ViewColorTuning::kWindow});
  cv::erode(figure, picture.inside,
            cv::getStructuringElement(cv::MORPH_RECT,
                                      {ViewColorTuning::kWindow, ViewColorTuning::kWindow}));
  return picture;
}

/// Pixel and depth of a point in a view; x < 0 if the view does not see it.
Eigen::Vector3d Seen(const View& view, const Eigen::Vector3d& x_in_world) {
  const Eigen::Vector3d x = view.camera_from_world * x_in_world;
  if (x.z() <= 0) return {-1, -1, 0};
  const Eigen::Vector2d pixel = view.camera.Project(x);
  if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < view.camera.width &&
        pixel.y() < view.camera.height))
    return {-1, -1, 0};
  return {pixel.x(), pixel.y(), x.z()};
}

/// Depth of the nearest point in each pixel; a point is as wide as the points' distance.
cv::Mat NearestDepths(const View& view, const PointCloud& surface, double cell) {
  cv::Mat depths(view.camera.height, view.camera.width, CV_32F,
                 cv::Scalar(std::numeric_limits<float>::infinity()));
  for (Eigen::Index i = 0; i < surface.points.rows(); ++i) {
    const Eigen::Vector3d at = Seen(view, surface.points.row(i));
    if (at.x() < 0) continue;
    const int half = static_cast<int>(std::ceil(0.5 * cell * view.camera.fx / at.z()));
    const int px = static_cast<int>(at.x()), py = static_cast<int>(at.y());
    for (int y = std::max(0, py - half); y <= std::min(depths.rows - 1, py + half); ++y)
      for (int x = std::max(0, px - half); x <= std::min(depths.cols - 1, px + half); ++x)
        depths.at<float>(y, x) = std::min(depths.at<float>(y, x), static_cast<float>(at.z()));
  }
  return depths;
}

/// Unit hue of each point that the view sees; zero for others.
PointsX3 HuesOf(const MaskedPicture& picture, const View& view, const PointCloud& surface,
                double cell) {
  const cv::Mat depths = NearestDepths(view, surface, cell);
  PointsX3 hues = PointsX3::Zero(surface.points.rows(), 3);
  const Eigen::Vector3d center = view.Center();
  for (Eigen::Index i = 0; i < surface.points.rows(); ++i) {
    const Eigen::Vector3d x = surface.points.row(i), at = Seen(view, x);
    if (at.x() < 0 ||
        surface.normals.row(i).dot((center - x).normalized()) < ViewColorTuning::kLeastCosine)
      continue;
    const int px = static_cast<int>(at.x()), py = static_cast<int>(at.y());
    if (!picture.inside.at<std::uint8_t>(py, px) ||
        at.z() > static_cast<double>(depths.at<float>(py, px)) + ViewColorTuning::kSlack * cell)
      continue;
    const auto& rgb = picture.mean.at<cv::Vec3b>(py, px);
    // sRGB values are roughly the square root of light; near black they have no hue.
    const Eigen::Vector3d root(rgb[0], rgb[1], rgb[2]);
    if (root.maxCoeff() > ViewColorTuning::kDark) hues.row(i) = root.normalized();
  }
  return hues;
}

/// Angles of all views' hues from the median of the inliers; negative where a view does not see the
/// point, or too few views do.
std::vector<double> AnglesAt(const std::vector<PointsX3>& hues, Eigen::Index point,
                             const std::vector<char>& inlier) {
  std::vector<double> angles(hues.size(), -1), values;
  Eigen::Vector3d middle;
  for (int c = 0; c < 3; ++c) {
    values.clear();
    for (std::size_t v = 0; v < hues.size(); ++v)
      if (inlier[v] && !hues[v].row(point).isZero(0)) values.push_back(hues[v](point, c));
    if (SizeOf(values) < kLeastViews) return angles;
    middle[c] = UpperMedianInPlace(values);
  }
  middle.normalize();
  for (std::size_t v = 0; v < hues.size(); ++v)
    if (!hues[v].row(point).isZero(0))
      angles[v] = std::acos(std::clamp(hues[v].row(point).dot(middle), -1.0, 1.0));
  return angles;
}

}  // namespace

std::vector<ColorFit> FitsOfColors(const std::vector<Image8>& images,
                                   const std::vector<Image8>& masks, const std::vector<View>& views,
                                   const PointCloud& surface, double cell,
                                   const std::vector<char>& inlier, const ColorOptions& options) {
  std::vector<PointsX3> hues(views.size());
  ParallelFor(std::ssize(views), [&](std::int64_t k) {
    const auto v = static_cast<std::size_t>(k);
    hues[v] = HuesOf(PictureOf(images[v], masks[v]), views[v], surface, cell);
  });
  std::vector<ColorFit> fits(views.size());
  for (Eigen::Index i = 0; i < surface.points.rows(); ++i) {
    const std::vector<double> angles = AnglesAt(hues, i, inlier);
    std::vector<double> of_inliers;
    for (std::size_t v = 0; v < angles.size(); ++v)
      if (inlier[v] && angles[v] >= 0) of_inliers.push_back(angles[v]);
    if (of_inliers.empty()) continue;
    const double limit = std::max(options.hue, options.spread * UpperMedian(std::move(of_inliers)));
    for (std::size_t v = 0; v < angles.size(); ++v) {
      if (angles[v] < 0) continue;
      ++fits[v].places;
      fits[v].contrary += angles[v] > limit;
    }
  }
  for (ColorFit& fit : fits) fit.contrary /= std::max(1, fit.places);
  return fits;
}

void CheckColors(const std::vector<ColorFit>& fits, const ColorOptions& options,
                 std::vector<char>& inlier) {
  for (std::size_t v = 0; v < fits.size(); ++v)
    if (fits[v].places >= options.least_places && fits[v].contrary > options.most_contrary)
      inlier[v] = 0;
}

}  // namespace keypose::capture
