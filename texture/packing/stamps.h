// Outlines as cells of a grid, for nesting.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/values/angles.h"
#include "core/values/mesh.h"
#include "core/values/size_of.h"

namespace keypose::texture {

inline constexpr int kTurns = 64;  ///< rotations in which outlines are placed

/// The points rotated about the origin [rad].
UvsX2 Turned(const UvsX2& points, double angle);

/// An outline with each vertex moved outwards along the mean normal of its two edges.
UvsX2 Widened(const UvsX2& p, double by);

/// Cells whose centres an outline covers, row by row.
struct Stamp {
  struct Span {
    int row, begin, end;
  };
  std::vector<Span> spans;
  int width = 0, height = 0, cells = 0;
  Eigen::Vector2d low = Eigen::Vector2d::Zero();  ///< [cells] lower corner of the rotated outline's
                                                  ///< box, before the move to the origin
};

/// @param outline_in_cells  moved so that the lower corner of its box is the origin. One with very
/// few cells is replaced by its box.
Stamp DrawStamp(const UvsX2& outline_in_cells);

/// A place and rotation on the grid.
struct Spot {
  int turn = 0, x = 0, y = 0;  ///< steps of 1 / kTurns of a full turn, and cells
};

/// The outlines at one scale, rasterised for each rotation at first use.
class Stamps {
 public:
  Stamps(const std::vector<UvsX2>& laid, double cells_per_unit, double widen)
      : laid_(laid), scale_(cells_per_unit), widen_(widen), drawn_(laid.size() * kTurns) {}
  const Stamp& Get(int item, int turn) {
    std::optional<Stamp>& stamp = drawn_[static_cast<std::size_t>(item) * kTurns + turn];
    if (!stamp)
      stamp = DrawStamp(Widened(Turned(laid_[item] * scale_, 2 * kPi * turn / kTurns), widen_));
    return *stamp;
  }
  double scale() const { return scale_; }

 private:
  const std::vector<UvsX2>& laid_;
  double scale_, widen_;
  std::vector<std::optional<Stamp>> drawn_;
};

/// For the bottom-left start: the last occupied cell at or before each cell, which gives the next
/// possible position after a collision.
class OccupiedCells {
 public:
  explicit OccupiedCells(int n) : n_(n), last_(static_cast<std::size_t>(n) * n, -1) {}
  void Add(const Stamp& stamp, int x, int y) {
    for (const Stamp::Span& span : stamp.spans) {
      std::int16_t* row = &last_[static_cast<std::size_t>(y + span.row) * n_];
      for (int c = x + span.begin; c < x + span.end; ++c) row[c] = static_cast<std::int16_t>(c);
      for (int c = x + span.end; c < n_ && row[c] < x + span.end - 1; ++c)
        row[c] = static_cast<std::int16_t>(x + span.end - 1);
    }
  }
  /// First free x at or after `x` in the rows from y, or -1.
  int FirstFree(const Stamp& stamp, int x, int y) const {
    const int count = SizeOf(stamp.spans);
    for (int clear = 0, at = 0; x + stamp.width <= n_;) {
      const Stamp::Span& span = stamp.spans[at];
      const int last = last_[static_cast<std::size_t>(y + span.row) * n_ + x + span.end - 1];
      if (last >= x + span.begin) {
        x = last + 1 - span.begin;
        clear = 0;
      } else if (++clear == count) {
        return x;
      }
      at = at + 1 < count ? at + 1 : 0;
    }
    return -1;
  }

 private:
  int n_;
  std::vector<std::int16_t> last_;
};

}  // namespace keypose::texture
