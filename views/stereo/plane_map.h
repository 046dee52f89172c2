// Packed planes and depths of all pixels of a view; at full resolution they are most of stereo's
// memory.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <vector>

#include "views/prepared/prepared_view.h"

namespace keypose::stereo {

/// A pixel's plane. Inverse depth is linear over the picture: 1/z(x + dx, y + dy) = inverse_depth +
/// dx gx + dy gy.
struct PlaneHypothesis {
  float inverse_depth = 0, gx = 0, gy = 0;
};

/// A plane, its costs and its source views for each pixel, row-major, in 15 bytes per pixel (16
/// with more than eight sources). Pixels without a plane have inverse depth 0 and infinite cost.
/// Tilts are rounded to 1/4096 (tangent of the slant, at most 8), costs to 1/16384.
class PlaneMap {
 public:
  int width = 0, height = 0;
  PlaneMap() = default;
  PlaneMap(const Pinhole& camera, int source_count)
      : width(camera.width),
        height(camera.height),
        unit_(static_cast<float>(1 / (kTiltSteps * camera.fx))),
        inverse_unit_(1 / unit_) {
    const std::size_t count = static_cast<std::size_t>(width) * height;
    planes_.assign(count, {});
    costs_.assign(count, kNoCost);
    match_.assign(count, {});
    first_sources_.assign(count, 0);
    more_sources_.assign(source_count > 8 ? count : 0, 0);
    many_sources_ = source_count > 8;
  }

  bool empty() const { return planes_.empty(); }
  std::size_t size() const { return planes_.size(); }
  float InverseDepth(std::size_t pixel) const { return planes_[pixel].inverse_depth; }
  PlaneHypothesis Plane(std::size_t pixel) const {
    const Packed& p = planes_[pixel];
    const float unit = p.inverse_depth * unit_;
    return {p.inverse_depth, p.gx * unit, p.gy * unit};
  }
  void SetPlane(std::size_t pixel, const PlaneHypothesis& plane) {
    const float scale = plane.inverse_depth > 0 ? inverse_unit_ / plane.inverse_depth : 0;
    planes_[pixel] = {plane.inverse_depth, Tilt(plane.gx * scale), Tilt(plane.gy * scale)};
  }
  float Cost(std::size_t pixel) const {
    return costs_[pixel] == kNoCost ? std::numeric_limits<float>::infinity()
                                    : costs_[pixel] * (1.0f / kCostSteps);
  }
  void SetCost(std::size_t pixel, float cost) {
    costs_[pixel] =
        static_cast<std::uint16_t>(std::clamp(cost * kCostSteps + 0.5f, 0.0f, kNoCost - 1.0f));
  }
  /// The part of the cost that comes from windows: in all used sources, and in the first two of
  /// them. It stays the same as long as plane and sources do.
  struct Match {
    float all = 0, pair = 0;
  };
  Match MatchOf(std::size_t pixel) const {
    return {match_[pixel].all * (1.0f / kCostSteps), match_[pixel].pair * (1.0f / kCostSteps)};
  }
  void SetMatch(std::size_t pixel, const Match& match) {
    auto steps = [](float cost) {
      return static_cast<std::uint16_t>(std::clamp(cost * kCostSteps + 0.5f, 0.0f, 65535.0f));
    };
    match_[pixel] = {steps(match.all), steps(match.pair)};
  }
  /// Frees data for further passes; none may follow.
  void DropMatches() { std::vector<PackedMatch>().swap(match_); }

  /// Keeps only the pixels that have a plane, about half of a picture that is cropped to its mask.
  /// Until Unpack, data is addressed by the place that Find returns, not by the pixel.
  void Pack() {
    present_.assign((planes_.size() + 63) / 64, 0);
    for (std::size_t pixel = 0; pixel < planes_.size(); ++pixel)
      if (planes_[pixel].inverse_depth > 0)
        present_[pixel / 64] |= std::uint64_t{1} << (pixel % 64);
    before_.clear();
    std::uint32_t count = 0;
    for (const std::uint64_t bits : present_) {
      before_.push_back(count);
      count += static_cast<std::uint32_t>(std::popcount(bits));
    }
    Keep(count, &planes_);
    Keep(count, &costs_);
    Keep(count, &first_sources_);
    if (!match_.empty()) Keep(count, &match_);
    if (many_sources_) Keep(count, &more_sources_);
  }
  void Unpack() {
    Spread({}, &planes_);
    Spread(kNoCost, &costs_);
    Spread({}, &first_sources_);
    if (!match_.empty()) Spread({}, &match_);
    if (many_sources_) Spread({}, &more_sources_);
    present_.clear();
    before_.clear();
  }
  bool packed() const { return !present_.empty(); }
  /// Place of a pixel's plane, whether packed or not; kNone when it has none.
  static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  std::size_t Find(std::size_t pixel) const {
    if (!packed()) return planes_[pixel].inverse_depth > 0 ? pixel : kNone;
    const std::uint64_t bits = present_[pixel / 64], bit = std::uint64_t{1} << (pixel % 64);
    return bits & bit
               ? before_[pixel / 64] + static_cast<std::size_t>(std::popcount(bits & (bit - 1)))
               : kNone;
  }
  /// Calls body(pixel, place) for all planes of a packed map, in the order of pixels.
  template <class Body>
  void ForEachPlane(const Body& body) const {
    std::size_t place = 0;
    for (std::size_t word = 0; word < present_.size(); ++word)
      for (std::uint64_t bits = present_[word]; bits; bits &= bits - 1)
        body(word * 64 + static_cast<std::size_t>(std::countr_zero(bits)), place++);
  }
  /// Bit k: the k-th source view is used here.
  std::uint16_t Sources(std::size_t pixel) const {
    return static_cast<std::uint16_t>(first_sources_[pixel] |
                                      (more_sources_.empty() ? 0 : more_sources_[pixel] << 8));
  }
  void SetSources(std::size_t pixel, std::uint16_t sources) {
    first_sources_[pixel] = static_cast<std::uint8_t>(sources & 255);
    if (!more_sources_.empty()) more_sources_[pixel] = static_cast<std::uint8_t>(sources >> 8);
  }
  /// Expected depth error, in pixels of this view on the surface. The last pass stores it in place
  /// of the sources. In steps of 3 %, between 1/64 and 24.
  float ExpectedError(std::size_t pixel) const {
    return kLeastError * std::exp2(first_sources_[pixel] * (1.0f / kErrorSteps));
  }
  void SetExpectedError(std::size_t pixel, float error) {
    first_sources_[pixel] = static_cast<std::uint8_t>(std::clamp(
        kErrorSteps * std::log2(std::max(error, kLeastError) / kLeastError) + 0.5f, 0.0f, 255.0f));
  }
  /// Has the same order as Cost and is cheaper to read; kNoCost where there is no plane.
  std::uint16_t PackedCost(std::size_t pixel) const { return costs_[pixel]; }
  static constexpr std::uint16_t kNoCost = 65535;

 private:
  static constexpr float kTiltSteps = 4096, kCostSteps = 16384, kErrorSteps = 24,
                         kLeastError = 1.0f / 64;
  struct Packed {
    float inverse_depth = 0;
    std::int16_t gx = 0, gy = 0;
  };
  struct PackedMatch {
    std::uint16_t all = 0, pair = 0;
  };
  template <class T>
  void Keep(std::size_t count, std::vector<T>* values) const {
    std::vector<T> kept;
    kept.reserve(count);
    ForEachPlane([&](std::size_t pixel, std::size_t) { kept.push_back((*values)[pixel]); });
    values->swap(kept);
  }
  template <class T>
  void Spread(const std::type_identity_t<T>& none, std::vector<T>* values) const {
    std::vector<T> spread(static_cast<std::size_t>(width) * height, none);
    ForEachPlane([&](std::size_t pixel, std::size_t place) { spread[pixel] = (*values)[place]; });
    values->swap(spread);
  }
  /// A slope that nothing says, not a number, is level: a conversion of it is not defined.
  static std::int16_t Tilt(float steps) {
    if (std::isnan(steps)) return 0;
    return static_cast<std::int16_t>(
        std::clamp(steps + (steps < 0 ? -0.5f : 0.5f), -32767.0f, 32767.0f));
  }

  float unit_ = 0, inverse_unit_ = 0;
  bool many_sources_ = false;
  std::vector<std::uint64_t> present_;  // of a packed map: one bit per pixel
  std::vector<std::uint32_t> before_;   // number of planes before each 64 pixels
  std::vector<Packed> planes_;
  std::vector<std::uint16_t> costs_;
  std::vector<PackedMatch> match_;
  std::vector<std::uint8_t> first_sources_, more_sources_;
};

/// One inverse depth per pixel in 16 bits, within known limits.
class DepthImage {
 public:
  int width = 0, height = 0;

  DepthImage() = default;
  DepthImage(int w, int h, float lowest, float highest)
      : width(w),
        height(h),
        low_(lowest),
        step_(std::max(highest - lowest, 1e-30f) / kSteps),
        data_(static_cast<std::size_t>(w) * h, 0) {}

  bool empty() const { return data_.empty(); }
  /// 0 where there is none.
  float At(std::size_t pixel) const { return data_[pixel] ? low_ + step_ * (data_[pixel] - 1) : 0; }
  float At(int x, int y) const { return At(static_cast<std::size_t>(y) * width + x); }
  void Set(std::size_t pixel, float inverse_depth) {
    data_[pixel] = inverse_depth > 0
                       ? static_cast<std::uint16_t>(
                             1.5f + std::clamp((inverse_depth - low_) / step_, 0.0f, kSteps))
                       : std::uint16_t{0};
  }

 private:
  static constexpr float kSteps = 65533;
  float low_ = 0, step_ = 1;
  std::vector<std::uint16_t> data_;
};

}  // namespace keypose::stereo
