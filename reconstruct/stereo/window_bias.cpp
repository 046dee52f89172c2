#include "reconstruct/stereo/window_bias.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "views/stereo/patch_match_warp.h"

namespace keypose::reconstruct {
namespace {

using stereo::kLanes, stereo::Lanes;

constexpr int kReach = 10;  // pixels
// errors of adjacent depths are correlated: every second depth has the same information
constexpr int kStep = 2;
constexpr float kEdge = 3;  // pixels of depth between a pixel and the mean of two opposite ones
// of the information on curvature in all groups together
constexpr float kLeastInformation = 0.25f;
// correction, pixels of depth: that of a bump smaller than the window
constexpr float kLargest = 2;
// unknown depths after each row, which also separate the rows
constexpr int kPadding = 2 * kReach + kLanes;

// A place and its three rotations by 90 degrees: the mean of their depths is the middle's depth
// plus a quarter of the Laplacian times the squared radius.
struct Four {
  std::ptrdiff_t at[4];
  float weight, squared;
};

std::vector<Four> Fours(std::ptrdiff_t stride) {
  std::vector<Four> fours;
  for (int dx = kStep; dx <= kReach; dx += kStep)
    for (int dy = 0; dy <= kReach; dy += kStep) {
      const int squared = dx * dx + dy * dy;
      if (squared > kReach * kReach) continue;
      auto at = [&](int x, int y) { return y * stride + x; };
      fours.push_back({{at(dx, dy), at(-dx, -dy), at(-dy, dx), at(dy, -dx)},
                       std::exp(-2.0f * static_cast<float>(squared) / (kReach * kReach)),
                       static_cast<float>(squared)});
    }
  return fours;
}

// Moments of the squared radii, and of the depths relative to the middle.
struct Moments {
  Lanes count{}, r2{}, r4{}, z{}, r2z{};
  Lanes Information() const { return r4 - r2 * r2 / count; }
  Lanes Slope() const { return (r2z - r2 * z / count) / Information(); }
};

Lanes Load(const float* from) {
  Lanes lanes;
  std::memcpy(&lanes, from, sizeof lanes);
  return lanes;
}

class Corrector {
 public:
  Corrector(const Pinhole& camera, const WindowBiasOptions& options, stereo::PlaneMap* map)
      : options_(options),
        map_(*map),
        stride_(map->width + kPadding),
        focal_(static_cast<float>(camera.fx)),
        fours_(Fours(stride_)) {
    depths_.assign(static_cast<std::size_t>(stride_) * (map_.height + 2 * kReach) + kPadding, 0.0f);
    ForEachGood([&](std::size_t pixel, std::size_t place) {
      depths_[Padded(pixel)] = map_.InverseDepth(place);
    });
    Moments all;
    for (const Four& four : fours_) {
      all.count += four.weight;
      all.r2 += four.weight * four.squared;
      all.r4 += four.weight * four.squared * four.squared;
    }
    least_information_ = kLeastInformation * all.Information();
  }

  void Run() {
    std::vector<float> corrections(depths_.size(), 0.0f);
    for (int y = 0; y < map_.height; ++y) {
      const std::size_t row = static_cast<std::size_t>(y + kReach) * stride_ + kReach;
      for (int x = 0; x < map_.width; x += kLanes) {
        const Lanes correction = Correction(depths_.data() + row + x);
        std::memcpy(corrections.data() + row + x, &correction, sizeof correction);
      }
    }
    ForEachGood([&](std::size_t pixel, std::size_t place) {
      stereo::PlaneHypothesis plane = map_.Plane(place);
      plane.inverse_depth += corrections[Padded(pixel)];
      map_.SetPlane(place, plane);
    });
  }

 private:
  template <class Body>
  void ForEachGood(const Body& body) const {
    const std::size_t count = static_cast<std::size_t>(map_.width) * map_.height;
    for (std::size_t pixel = 0; pixel < count; ++pixel) {
      const std::size_t place = map_.Find(pixel);
      if (place != stereo::PlaneMap::kNone && map_.Cost(place) <= options_.largest_cost &&
          map_.ExpectedError(place) <= options_.largest_error)
        body(pixel, place);
    }
  }
  std::size_t Padded(std::size_t pixel) const {
    return (pixel / map_.width + kReach) * stride_ + kReach + pixel % map_.width;
  }

  // Correction of inverse depth, for adjacent pixels; 0 where it is not determined.
  Lanes Correction(const float* at) const {
    const Lanes here = Load(at), none{};
    const stereo::LaneInts present = here > 0.0f;
    if (!(present[0] | present[1] | present[2] | present[3])) return none;
    const Lanes unit = (present ? here : Lanes{} + 1.0f) / focal_;  // one pixel of depth
    const Lanes edge = kEdge * unit;
    Moments moments;
    for (const Four& four : fours_) {
      const Lanes a = Load(at + four.at[0]), b = Load(at + four.at[1]), c = Load(at + four.at[2]),
                  d = Load(at + four.at[3]);
      const Lanes first = 0.5f * (a + b) - here, second = 0.5f * (c + d) - here;
      const stereo::LaneInts good = present & (a > 0.0f) & (b > 0.0f) & (c > 0.0f) & (d > 0.0f) &
                                    (first < edge) & (first > -edge) & (second < edge) &
                                    (second > -edge);
      const Lanes weight = good ? Lanes{} + four.weight : none,
                  z = weight * (0.5f * (first + second));
      moments.count += weight;
      moments.r2 += weight * four.squared;
      moments.r4 += weight * (four.squared * four.squared);
      moments.z += z;
      moments.r2z += four.squared * z;
    }
    const auto known =
        (moments.count > 0.0f) & (moments.Information() > least_information_);  // false for NaN
    const Lanes laplacian = 4.0f * moments.Slope(), most = kLargest * unit;
    Lanes correction = static_cast<float>(-0.5 * options_.variance) * laplacian;
    const Lanes raised = correction < -most ? -most : correction;
    correction = correction > most ? most : raised;
    return known ? correction : none;
  }

  const WindowBiasOptions& options_;
  stereo::PlaneMap& map_;
  const std::ptrdiff_t stride_;
  const float focal_;
  const std::vector<Four> fours_;
  std::vector<float> depths_;  // inverse; 0 where they are not reliable, with a margin on all sides
  Lanes least_information_{};
};

}  // namespace

void CorrectWindowBias(const Pinhole& camera, const WindowBiasOptions& options,
                       stereo::PlaneMap* map) {
  if (options.variance <= 0 || map->empty()) return;
  Corrector(camera, options, map).Run();
}

}  // namespace keypose::reconstruct
