// Odds of object against background for a pixel, from its colour and its local contrast.
#pragma once

#include <vector>

#include "core/values/image.h"

namespace keypose::capture {

/// Smoothed histograms of object and background. Colour is Lab (32 x 64 x 64 bins). Contrast is the
/// standard deviation of lightness around a pixel; it separates fur from a wall of the same colour.
/// The two are assumed to be independent.
class ColorOdds {
 public:
  /// Counts the pixels of an RGB image under its trimap.
  void Add(const Image8& image, const Image8& trimap);
  /// Adds another's counts times `weight`. Call before Finish.
  void Add(const ColorOdds& other, float weight);
  /// Converts counts to shares; call once, after all calls of Add.
  void Finish();
  /// ln p(pixel | object) / p(pixel | background) of each pixel, clamped to +-limit.
  ImageF Of(const Image8& image, double limit) const;

 private:
  struct Histograms {
    std::vector<float> color, contrast;
    float total = 0;
  };
  Histograms histograms_[2];  // background, object
};

}  // namespace keypose::capture
