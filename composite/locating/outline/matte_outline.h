// The outline of a matte, to a fraction of a pixel.
#pragma once

#include <memory>
#include <vector>

#include "core/numbers/kd_tree.h"
#include "core/values/image.h"

namespace keypose::composite {

/// Outlines are partners when the cosine between their normals is at least this; so many of the
/// nearest points are tried.
constexpr double kLeastAgreement = 0.5;
constexpr int kTriedNeighbours = 16;

/// Pixel centres lie at .5 here and in all of locating/, as in core/values/camera.h.
struct OutlinePoint {
  Eigen::Vector2d pixel;
  Eigen::Vector2d normal;  ///< unit, outwards
};

/// About one point for each pixel of the outline, with a search for the nearest. None near the
/// picture's sides, where the figure may continue.
class MatteOutline {
 public:
  /// @param matte  1 channel; 255 is the figure, values between are its share of the pixel
  explicit MatteOutline(const Image8& matte);

  const std::vector<OutlinePoint>& points() const { return points_; }
  int width() const { return width_; }
  int height() const { return height_; }
  /// The nearest point within `reach_px` whose normal differs by less than 60 degrees; -1: none.
  int Nearest(const Eigen::Vector2d& pixel, const Eigen::Vector2d& normal, double reach_px) const;
  /// Whether the pixel is so near to a side of the picture that the outline is not known there.
  bool Cut(const Eigen::Vector2d& pixel) const;

 private:
  std::vector<OutlinePoint> points_;
  std::shared_ptr<const KdTree> tree_;  // null when there are no points
  int width_ = 0, height_ = 0;
};

/// Share of the figure in the picture, 0 to 1.
double MatteShare(const Image8& matte);

/// A blur of standard deviation one pixel, 1 channel.
ImageF SlightlyBlurred(const Image8& grey);

}  // namespace keypose::composite
