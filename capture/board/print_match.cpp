#include "capture/board/print_match.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "capture/board/checkerboard.h"
#include "core/values/size_of.h"

namespace keypose::capture {
namespace {

using Eigen::Vector2d;

constexpr double kAgrees = 0.5, kClearly = 0.2;  // correlation of the bits, and of the next place

/// A corner's column and row on the board, for one in the grid: turned by quarters, then moved.
struct GridPlace {
  int quarters = 0, column = 0, row = 0;

  std::pair<int, int> OnBoard(const CheckerGrid& grid, int c, int r) const {
    int columns = grid.columns, rows = grid.rows;
    for (int i = 0; i < quarters; ++i) {
      const int turned = rows - 1 - r;
      r = c;
      c = turned;
      std::swap(columns, rows);
    }
    return {c + column, r + row};
  }
};

/// The print's bits, as points of the board in squares and whether they are white.
struct PrintBits {
  std::vector<Vector2d> at;
  std::vector<double> white;
};

PrintBits BitsOfPrint(const BoardPattern& pattern) {
  PrintBits bits;
  const double share = pattern.layout.marker_m / pattern.layout.square_m;
  for (int marker = 0; marker < pattern.MarkerCount(); ++marker) {
    const auto [column, row] = pattern.SquareOf(marker);
    const auto ink = MarkerInk(pattern.dictionary, marker);
    const int cells = SizeOf(ink);
    for (int r = 1; r + 1 < cells; ++r)
      for (int c = 1; c + 1 < cells; ++c) {
        bits.at.emplace_back(column + (1 - share) / 2 + share * (c + 0.5) / cells,
                             row + (1 - share) / 2 + share * (r + 0.5) / cells);
        bits.white.push_back(ink[r][c] ? 0 : 1);
      }
  }
  return bits;
}

double BrightnessAt(const Image8& grey, const Vector2d& pixel) {
  const double x = std::clamp(pixel.x() - 0.5, 0.0, grey.width - 1.001);
  const double y = std::clamp(pixel.y() - 0.5, 0.0, grey.height - 1.001);
  const int ix = static_cast<int>(x), iy = static_cast<int>(y);
  const double u = x - ix, v = y - iy;
  return (1 - v) * ((1 - u) * *grey.at(ix, iy) + u * *grey.at(ix + 1, iy)) +
         v * ((1 - u) * *grey.at(ix, iy + 1) + u * *grey.at(ix + 1, iy + 1));
}

/// Correlation of the print's bits with the picture; 0 where the squares' colours disagree.
double CorrelationOf(const Image8& grey, const CheckerGrid& grid, const GridPlace& place,
                     const PrintBits& bits) {
  std::vector<cv::Point2d> board, seen;
  for (const CheckerGrid::Corner& corner : grid.corners) {
    const auto [c, r] = place.OnBoard(grid, corner.column, corner.row);
    board.emplace_back(c + 1, r + 1);
    seen.emplace_back(corner.pixel.x(), corner.pixel.y());
  }
  const cv::Mat h = cv::findHomography(board, seen);
  if (h.empty()) return 0;
  const Eigen::Matrix3d map =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(h.ptr<double>());
  double count = 0, s = 0, t = 0, ss = 0, tt = 0, st = 0;
  for (int i = 0; i < SizeOf(bits.at); ++i) {
    const Vector2d pixel = (map * bits.at[i].homogeneous()).hnormalized();
    if (!(pixel.x() > 1 && pixel.y() > 1 && pixel.x() < grey.width - 1 &&
          pixel.y() < grey.height - 1))
      continue;
    const double level = BrightnessAt(grey, pixel), white = bits.white[i];
    count += 1;
    s += level;
    t += white;
    ss += level * level;
    tt += white * white;
    st += level * white;
  }
  const double variance = (ss - s * s / count) * (tt - t * t / count);
  return count > 8 && variance > 0 ? (st - s * t / count) / std::sqrt(variance) : 0;
}

}  // namespace

std::vector<BoardCorner> MatchPrint(const Image8& grey, const BoardPattern& pattern,
                                    double enlarged) {
  const CheckerGrid grid = FindCornerGrid(grey, enlarged);
  if (grid.empty()) return {};
  const int columns = pattern.layout.columns - 1, rows = pattern.layout.rows - 1;
  const PrintBits bits = BitsOfPrint(pattern);
  GridPlace best;
  double most = 0, next = 0;
  for (int quarters = 0; quarters < 4; ++quarters) {
    const int across = quarters % 2 ? grid.rows : grid.columns,
              down = quarters % 2 ? grid.columns : grid.rows;
    for (int row = 0; row + down <= rows; ++row)
      for (int column = 0; column + across <= columns; ++column) {
        const GridPlace place{quarters, column, row};
        const double agrees = CorrelationOf(grey, grid, place, bits);
        next = std::max(next, std::min(agrees, most));
        if (agrees > most) {
          most = agrees;
          best = place;
        }
      }
  }
  if (most < kAgrees || most < next + kClearly) return {};
  std::vector<BoardCorner> corners;
  for (const CheckerGrid::Corner& corner : grid.corners) {
    const auto [c, r] = best.OnBoard(grid, corner.column, corner.row);
    corners.push_back({r * columns + c, corner.pixel});
  }
  return corners;
}

}  // namespace keypose::capture
