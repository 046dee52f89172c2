// What a pass of PatchMatch holds of sources, tried planes and the coarser level.
#pragma once

#include <algorithm>
#include <cmath>

#include "views/stereo/patch_match_cost.h"
#include "views/stereo/patch_match_warp.h"
#include "views/stereo/plane_map.h"

namespace keypose::stereo {

/// Up to four of the sources, in the layout for matching them together.
struct SourceLanes {
  int count = 0;
  int ids[kLanes] = {};  // unused lanes repeat the first
  TransferLanes to, from;
  const SampleImage* images[kLanes] = {};
  const DepthImage* depths[kLanes] = {};
  Lanes depth_width{}, depth_height{};
  LaneInts depth_stride{};
};

/// A plane that is matched, and its costs so far.
struct Trial {
  PlaneHypothesis plane;
  WarpLanes warps;
  float sum = 0;
  float pair = 0;   // the sum after the first two sources
  float extra = 0;  // the part of the sum that does not come from windows
};

/// Interpolated between the four pixels of the coarser level around; across a depth edge, the one
/// that covers this pixel.
inline __attribute__((always_inline)) float PriorAt(const DepthImage& coarse, int x, int y,
                                                    float px_per_inverse_depth) {
  const int px = std::min(x / 2, coarse.width - 1), py = std::min(y / 2, coarse.height - 1);
  const int qx = std::clamp(px + (x & 1 ? 1 : -1), 0, coarse.width - 1),
            qy = std::clamp(py + (y & 1 ? 1 : -1), 0, coarse.height - 1);
  const float here = coarse.At(px, py);
  if (here <= 0) return 0;
  auto near = [&](float depth) {
    return depth > 0 && std::abs(depth - here) * px_per_inverse_depth < 3 ? depth : here;
  };
  return 0.5625f * here + 0.1875f * (near(coarse.At(qx, py)) + near(coarse.At(px, qy))) +
         0.0625f * near(coarse.At(qx, qy));
}

}  // namespace keypose::stereo
