#include "texture/packing/stamps.h"

#include <algorithm>
#include <cmath>

namespace keypose::texture {
namespace {

// an outline with fewer cells is replaced by its box: half a cell of overlap would be too much for
// it
constexpr int kFewCells = 60;

}  // namespace

UvsX2 Turned(const UvsX2& points, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  UvsX2 out(points.rows(), 2);
  out.col(0) = c * points.col(0) - s * points.col(1);
  out.col(1) = s * points.col(0) + c * points.col(1);
  return out;
}

UvsX2 Widened(const UvsX2& p, double by) {
  const Eigen::Index n = p.rows();
  UvsX2 out = p;
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::RowVector2d before = p.row(i) - p.row((i + n - 1) % n),
                             after = p.row((i + 1) % n) - p.row(i);
    const double a = before.norm(), b = after.norm();
    if (!(a > 0) || !(b > 0)) continue;
    const Eigen::RowVector2d along = before / a + after / b;
    const double length = along.norm();
    if (!(length > 0.2)) continue;  // the tip of a spike stays
    // 2 / length: a corner moves farther so that its edges move by `by`.
    out.row(i) +=
        Eigen::RowVector2d(along.y(), -along.x()) / length * (by * std::min(2 / length, 1.5));
  }
  return out;
}

Stamp DrawStamp(const UvsX2& outline_in_cells) {
  Stamp stamp;
  stamp.low = outline_in_cells.colwise().minCoeff().transpose();
  const UvsX2 p = outline_in_cells.rowwise() - stamp.low.transpose();
  const Eigen::RowVector2d extent = p.colwise().maxCoeff();
  stamp.width = std::max(1, static_cast<int>(std::ceil(extent.x() - 1e-6)));
  stamp.height = std::max(1, static_cast<int>(std::ceil(extent.y() - 1e-6)));
  std::vector<std::vector<double>> crossings(stamp.height);
  for (Eigen::Index i = 0; i < p.rows(); ++i) {
    const Eigen::RowVector2d a = p.row(i), b = p.row((i + 1) % p.rows());
    const double low = std::min(a.y(), b.y()), high = std::max(a.y(), b.y());
    for (int row = std::max(0, static_cast<int>(std::ceil(low - 0.5)));
         row < stamp.height && row + 0.5 < high; ++row)
      crossings[row].push_back(a.x() + (b.x() - a.x()) * (row + 0.5 - a.y()) / (b.y() - a.y()));
  }
  for (int row = 0; row < stamp.height; ++row) {
    std::vector<double>& x = crossings[row];
    std::sort(x.begin(), x.end());
    for (std::size_t k = 0; k + 1 < x.size(); k += 2) {
      const int begin = std::max(0, static_cast<int>(std::ceil(x[k] - 0.5)));
      const int end = std::min(stamp.width, static_cast<int>(std::ceil(x[k + 1] - 0.5)));
      if (begin >= end) continue;
      if (!stamp.spans.empty() && stamp.spans.back().row == row &&
          stamp.spans.back().end >= begin) {
        // widened bays may overlap themselves
        stamp.spans.back().end = std::max(stamp.spans.back().end, end);
      } else {
        stamp.spans.push_back({row, begin, end});
      }
    }
  }
  for (const Stamp::Span& span : stamp.spans) stamp.cells += span.end - span.begin;
  if (stamp.cells >= kFewCells) return stamp;
  stamp.spans.clear();
  stamp.cells = stamp.width * stamp.height;
  for (int row = 0; row < stamp.height; ++row) stamp.spans.push_back({row, 0, stamp.width});
  return stamp;
}

}  // namespace keypose::texture
