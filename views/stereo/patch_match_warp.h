// How planes of a reference view map to source views: four sources at a time, one per lane.
#pragma once

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

#include <Eigen/Core>
#include <cmath>
#include <cstdint>

#include "views/prepared/prepared_view.h"
#include "views/stereo/patch_match_cost.h"
#include "views/stereo/plane_map.h"

namespace keypose::stereo {

/// Source pixel ~ a (x, y, 1) + b * inverse depth: K_s R K_r^-1 and K_s t.
struct Transfer {
  Eigen::Matrix3f a;
  Eigen::Vector3f b;
};
Transfer MakeTransfer(const PreparedView& from, const PreparedView& to, int level);

/// Four numbers for one instruction (vector extension of GCC and Clang, on any processor).
using Lanes = float __attribute__((vector_size(sizeof(float) * kLanes)));
using LaneInts = std::int32_t __attribute__((vector_size(sizeof(std::int32_t) * kLanes)));

inline Lanes SquareRoots(const Lanes& x) {
#if defined(__SSE__)
  return _mm_sqrt_ps(x);
#else
  Lanes roots;
  for (int lane = 0; lane < kLanes; ++lane) roots[lane] = std::sqrt(x[lane]);
  return roots;
#endif
}

/// Up to four transfers from one reference; PixelLanes has their values at one pixel: the
/// homogeneous source pixel of the pixel's ray at infinity.
struct TransferLanes {
  Lanes x[3] = {}, y[3] = {}, one[3] = {}, depth[3] = {};
  void Set(int lane, const Transfer& transfer);
};
struct PixelLanes {
  Lanes base[3];
};
inline PixelLanes AtPixel(const TransferLanes& t, float px, float py) {
  return {{t.x[0] * px + t.y[0] * py + t.one[0], t.x[1] * px + t.y[1] * py + t.one[1],
           t.x[2] * px + t.y[2] * py + t.one[2]}};
}

/// The pixel's plane in each lane's source: homography H = K_s (R - t n^T / d) K_r^-1 in the form
/// of WarpLanes. Windows that reach the source camera's plane are moved far outside.
/// @param pixel, plane  at the window's middle
/// @param scale         pixels per unit of the window's offsets
WarpLanes WarpsOf(const TransferLanes& transfers, const PixelLanes& pixel,
                  const PlaneHypothesis& plane, float scale = 1);

}  // namespace keypose::stereo
