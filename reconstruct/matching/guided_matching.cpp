#include "reconstruct/matching/guided_matching.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace keypose::reconstruct {
namespace {

constexpr int kSize = 128;
constexpr double kCell_px = 12;

int Dot(const std::int16_t* a, const std::int16_t* b) {
  int sum = 0;
  for (int k = 0; k < kSize; ++k) sum += static_cast<int>(a[k]) * static_cast<int>(b[k]);
  return sum;
}

/// Features by square cells of the image.
class Grid {
 public:
  explicit Grid(const Features& features) {
    if (features.count() == 0) return;
    low_ = features.positions.colwise().minCoeff().transpose().cast<double>();
    const Eigen::Vector2d size =
        features.positions.colwise().maxCoeff().transpose().cast<double>() - low_;
    columns_ = static_cast<int>(size.x() / kCell_px) + 1;
    rows_ = static_cast<int>(size.y() / kCell_px) + 1;
    cells_.resize(static_cast<std::size_t>(columns_) * rows_);
    for (int i = 0; i < features.count(); ++i)
      cells_[CellOf((features.positions(i, 0) - low_.x()) / kCell_px,
                    (features.positions(i, 1) - low_.y()) / kCell_px)]
          .push_back(i);
  }

  /// Calls visit(feature) for all features within `reach` of the line and some more.
  template <class Visit>
  void AlongLine(const Eigen::Vector3d& line, double reach, const Visit& visit) const {
    // Visits cell by cell along the axis in which the line advances faster; the other coordinate
    // follows from the line.
    const bool along_x = std::abs(line.y()) >= std::abs(line.x());
    const double across = along_x ? line.y() : line.x(), along = along_x ? line.x() : line.y();
    if (across == 0) return;
    const double margin = reach * line.head<2>().norm() / std::abs(across);
    const double low_along = along_x ? low_.x() : low_.y(),
                 low_across = along_x ? low_.y() : low_.x();
    for (int k = 0; k < (along_x ? columns_ : rows_); ++k) {
      const double from = low_along + k * kCell_px, at_from = -(along * from + line.z()) / across,
                   at_to = -(along * (from + kCell_px) + line.z()) / across;
      const int first =
                    Clamped((std::min(at_from, at_to) - margin - low_across) / kCell_px, along_x),
                last =
                    Clamped((std::max(at_from, at_to) + margin - low_across) / kCell_px, along_x);
      for (int l = first; l <= last; ++l)
        for (const int i : along_x ? Cell(k, l) : Cell(l, k)) visit(i);
    }
  }

  template <class Visit>
  void Around(const Eigen::Vector2d& point, double reach, const Visit& visit) const {
    const Eigen::Vector2d first = (point.array() - reach - low_.array()) / kCell_px,
                          last = (point.array() + reach - low_.array()) / kCell_px;
    for (int row = Clamped(first.y(), true); row <= Clamped(last.y(), true); ++row)
      for (int column = Clamped(first.x(), false); column <= Clamped(last.x(), false); ++column)
        for (const int i : Cell(column, row)) visit(i);
  }

 private:
  std::size_t CellOf(double x, double y) const {
    return static_cast<std::size_t>(static_cast<int>(y) * columns_ + static_cast<int>(x));
  }
  const std::vector<int>& Cell(int column, int row) const {
    return cells_[row * columns_ + column];
  }
  int Clamped(double cell, bool row) const {
    return static_cast<int>(
        std::clamp(std::floor(cell), 0.0, static_cast<double>((row ? rows_ : columns_) - 1)));
  }

  Eigen::Vector2d low_ = Eigen::Vector2d::Zero();
  int columns_ = 0, rows_ = 0;
  std::vector<std::vector<int>> cells_;
};

}  // namespace

std::vector<std::pair<std::uint32_t, std::uint32_t>> MatchGuided(const Features& a,
                                                                 const Features& b,
                                                                 const PairGeometry& geometry,
                                                                 const MatchOptions& options,
                                                                 double max_error_px) {
  if (geometry.kind == PairGeometry::kOther || a.count() == 0 || b.count() == 0) return {};
  std::vector<NearestTwo> of_a(static_cast<std::size_t>(a.count())),
      of_b(static_cast<std::size_t>(b.count()));
  const Grid grid(b);
  const Eigen::Matrix3d& m = geometry.matrix;
  const double limit = max_error_px * max_error_px;
  for (int i = 0; i < a.count(); ++i) {
    const auto offer = [&](int j) {
      const int dot = Dot(a.descriptors.data() + static_cast<std::ptrdiff_t>(i) * kSize,
                          b.descriptors.data() + static_cast<std::ptrdiff_t>(j) * kSize);
      of_a[i].Offer(dot, j);
      of_b[j].Offer(dot, i);
    };
    const Eigen::Vector3d x = a.positions.row(i).transpose().cast<double>().homogeneous();
    if (geometry.kind == PairGeometry::kHomography) {
      const Eigen::Vector2d target = (m * x).hnormalized();
      if (!target.allFinite()) continue;
      grid.Around(target, max_error_px, [&](int j) {
        if ((b.positions.row(j).transpose().cast<double>() - target).squaredNorm() <= limit)
          offer(j);
      });
      continue;
    }
    const Eigen::Vector3d line = m * x;
    const double norm2 = line.head<2>().squaredNorm();
    grid.AlongLine(line, std::sqrt(2.0) * max_error_px, [&](int j) {
      const Eigen::Vector3d y = b.positions.row(j).transpose().cast<double>().homogeneous();
      const double e2 = std::pow(y.dot(line), 2);
      if (e2 <= 2 * limit * norm2 &&
          e2 <= limit * (norm2 + (m.transpose() * y).head<2>().squaredNorm()))
        offer(j);
    });
  }
  return MutualMatches(of_a, of_b, options);
}

}  // namespace keypose::reconstruct
