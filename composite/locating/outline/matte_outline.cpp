#include "composite/locating/outline/matte_outline.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/values/size_of.h"

namespace keypose::composite {
namespace {

constexpr double kSide = 3;  // px, without outline
constexpr float kHalf = 127.5f;

Eigen::Vector2d GradientAt(const ImageF& image, double x, double y) {
  // Over three pixels, because the outline of a hard matte is a staircase.
  const int x0 = std::clamp(static_cast<int>(std::lround(x)), 2, image.width - 3);
  const int y0 = std::clamp(static_cast<int>(std::lround(y)), 2, image.height - 3);
  Eigen::Vector2d g = Eigen::Vector2d::Zero();
  for (int dy = -2; dy <= 2; ++dy)
    for (int dx = -2; dx <= 2; ++dx)
      g += Eigen::Vector2d(dx, dy) * static_cast<double>(*image.at(x0 + dx, y0 + dy));
  return g;
}

/// Adds the place where the matte passes one half between two neighbours.
void AddCrossing(const ImageF& soft, int x, int y, int dx, int dy,
                 std::vector<OutlinePoint>& points) {
  const float a = *soft.at(x, y) - kHalf, b = *soft.at(x + dx, y + dy) - kHalf;
  if ((a > 0) == (b > 0)) return;
  const double t = static_cast<double>(a) / (static_cast<double>(a) - static_cast<double>(b));
  const Eigen::Vector2d at(x + t * dx, y + t * dy), normal = -GradientAt(soft, at.x(), at.y());
  const double length = normal.norm();
  if (length < 1e-6) return;
  // A crossing counts where its direction cuts the outline more steeply, so that there is about one
  // for each pixel.
  if (std::abs(dx ? normal.x() : normal.y()) < std::abs(dx ? normal.y() : normal.x())) return;
  points.push_back({at + Eigen::Vector2d::Constant(0.5), normal / length});
}

}  // namespace

ImageF SlightlyBlurred(const Image8& grey) {
  constexpr std::array<float, 5> kWeights{0.0545f, 0.2442f, 0.4026f, 0.2442f, 0.0545f};
  const int w = grey.width, h = grey.height;
  ImageF rows(w, h, 1), soft(w, h, 1);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      float sum = 0;
      for (int k = -2; k <= 2; ++k)
        sum += kWeights[k + 2] * static_cast<float>(grey.at(std::clamp(x + k, 0, w - 1), y)[0]);
      *rows.at(x, y) = sum;
    }
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x) {
      float sum = 0;
      for (int k = -2; k <= 2; ++k)
        sum += kWeights[k + 2] * *rows.at(x, std::clamp(y + k, 0, h - 1));
      *soft.at(x, y) = sum;
    }
  return soft;
}

MatteOutline::MatteOutline(const Image8& matte) : width_(matte.width), height_(matte.height) {
  if (width_ < 8 || height_ < 8) return;
  const ImageF soft = SlightlyBlurred(matte);
  const int side = static_cast<int>(kSide);
  for (int y = side; y + 1 + side < height_; ++y)
    for (int x = side; x + 1 + side < width_; ++x) {
      AddCrossing(soft, x, y, 1, 0, points_);
      AddCrossing(soft, x, y, 0, 1, points_);
    }
  if (points_.empty()) return;
  PointsX3 flat(SizeOf(points_), 3);
  for (int i = 0; i < SizeOf(points_); ++i)
    flat.row(i) << points_[i].pixel.x(), points_[i].pixel.y(), 0;
  tree_ = std::make_shared<const KdTree>(flat);
}

int MatteOutline::Nearest(const Eigen::Vector2d& pixel, const Eigen::Vector2d& normal,
                          double reach_px) const {
  if (!tree_) return -1;
  for (const KdTree::Neighbor& near :
       tree_->Nearest(Eigen::Vector3d(pixel.x(), pixel.y(), 0), kTriedNeighbours)) {
    if (near.squared_distance > reach_px * reach_px) return -1;
    if (points_[near.index].normal.dot(normal) >= kLeastAgreement) return near.index;
  }
  return -1;
}

bool MatteOutline::Cut(const Eigen::Vector2d& p) const {
  const double side = kSide + 1;
  return p.x() < side || p.y() < side || p.x() > width_ - side || p.y() > height_ - side;
}

double MatteShare(const Image8& matte) {
  const auto inside = std::count_if(matte.data.begin(), matte.data.end(),
                                    [](std::uint8_t value) { return value > 127; });
  return matte.empty() ? 0 : static_cast<double>(inside) / static_cast<double>(matte.data.size());
}

}  // namespace keypose::composite
