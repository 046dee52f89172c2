#include "capture/segmentation/colour_odds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "capture/segmentation/trimap.h"

namespace keypose::capture {
namespace {

// Chroma has finer bins than lightness: a background and white fur often differ only slightly in
// chroma.
constexpr int kLightBins = 32, kChromaBins = 64, kContrastBins = 24;
constexpr int kColorBins = kLightBins * kChromaBins * kChromaBins;
constexpr double kPrior = 2e-6;  // share of a colour that never occurred

struct Features {
  cv::Mat lab, contrast;  // 8UC3, 32F
};

Features FeaturesOf(const Image8& image) {
  const cv::Mat rgb(image.height, image.width, CV_8UC3,
                    const_cast<std::uint8_t*>(image.data.data()));
  Features features;
  cv::cvtColor(rgb, features.lab, cv::COLOR_RGB2Lab);
  cv::Mat light, mean, mean_square;
  cv::extractChannel(features.lab, light, 0);
  light.convertTo(light, CV_32F);
  cv::boxFilter(light, mean, CV_32F, {5, 5});
  cv::boxFilter(light.mul(light), mean_square, CV_32F, {5, 5});
  cv::sqrt(cv::max(mean_square - mean.mul(mean), 0), features.contrast);
  return features;
}

std::size_t ColorBin(const cv::Vec3b& lab) {
  return static_cast<std::size_t>(((lab[0] >> 3) * kChromaBins + (lab[1] >> 2)) * kChromaBins +
                                  (lab[2] >> 2));
}

std::size_t ContrastBin(float contrast) {
  return static_cast<std::size_t>(
      std::clamp(static_cast<int>(4 * std::log2(1 + contrast)), 0, kContrastBins - 1));
}

/// Binomial 1-4-6-4-1 along one axis: a Gaussian of one bin.
void SmoothAxis(std::vector<float>& bins, int stride, int length) {
  std::array<float, 64> line{};
  for (int start = 0; start < std::ssize(bins); ++start) {
    if (start / stride % length != 0) continue;
    for (int i = 0; i < length; ++i) line[i] = bins[start + i * stride];
    const auto at = [&](int i) { return line[std::clamp(i, 0, length - 1)]; };
    for (int i = 0; i < length; ++i)
      bins[start + i * stride] =
          (at(i - 2) + 4 * at(i - 1) + 6 * at(i) + 4 * at(i + 1) + at(i + 2)) / 16;
  }
}

void Scale(std::vector<float>& bins, float factor) {
  for (float& bin : bins) bin *= factor;
}

}  // namespace

void ColorOdds::Add(const Image8& image, const Image8& trimap) {
  const Features features = FeaturesOf(image);
  for (Histograms& h : histograms_) {
    h.color.resize(kColorBins);
    h.contrast.resize(kContrastBins);
  }
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const std::uint8_t label = *trimap.at(x, y);
      if (label != kBackground && label != kObject) continue;
      Histograms& h = histograms_[label == kObject];
      h.color[ColorBin(features.lab.at<cv::Vec3b>(y, x))] += 1;
      h.contrast[ContrastBin(features.contrast.at<float>(y, x))] += 1;
      h.total += 1;
    }
}

void ColorOdds::Add(const ColorOdds& other, float weight) {
  for (int z = 0; z < 2; ++z) {
    Histograms& h = histograms_[z];
    h.color.resize(kColorBins);
    h.contrast.resize(kContrastBins);
    for (std::size_t i = 0; i < other.histograms_[z].color.size(); ++i)
      h.color[i] += weight * other.histograms_[z].color[i];
    for (std::size_t i = 0; i < other.histograms_[z].contrast.size(); ++i)
      h.contrast[i] += weight * other.histograms_[z].contrast[i];
    h.total += weight * other.histograms_[z].total;
  }
}

void ColorOdds::Finish() {
  for (Histograms& h : histograms_) {
    SmoothAxis(h.color, kChromaBins * kChromaBins, kLightBins);
    SmoothAxis(h.color, kChromaBins, kChromaBins);
    SmoothAxis(h.color, 1, kChromaBins);
    SmoothAxis(h.contrast, 1, kContrastBins);
    const float share = 1 / std::max(h.total, 1.0F);
    Scale(h.color, share);
    Scale(h.contrast, share);
  }
}

ImageF ColorOdds::Of(const Image8& image, double limit) const {
  const Features features = FeaturesOf(image);
  const Histograms &background = histograms_[0], &object = histograms_[1];
  ImageF odds(image.width, image.height, 1);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const std::size_t color = ColorBin(features.lab.at<cv::Vec3b>(y, x)),
                        contrast = ContrastBin(features.contrast.at<float>(y, x));
      const double by_color =
          std::log((object.color[color] + kPrior) / (background.color[color] + kPrior));
      const double by_contrast =
          std::log((object.contrast[contrast] + 1e-3) / (background.contrast[contrast] + 1e-3));
      *odds.at(x, y) = static_cast<float>(std::clamp(by_color + by_contrast, -limit, limit));
    }
  return odds;
}

}  // namespace keypose::capture
