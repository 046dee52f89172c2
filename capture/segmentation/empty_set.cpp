#include "capture/segmentation/empty_set.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "capture/pictures/cv_image.h"
#include "capture/segmentation/trimap.h"

namespace keypose::capture {
namespace {

constexpr std::size_t kMostOfTake = 21;  // photographs for a median
constexpr std::size_t kLeastOfTake = 3;

/// Small grey borders, which the figure does not cover in most photographs.
std::vector<float> BorderSignature(const Image8& image, double border_share) {
  constexpr int kWidth = 96;
  cv::Mat small, grey;
  cv::resize(MatOf(image), small, {kWidth, std::max(8, kWidth * image.height / image.width)}, 0, 0,
             cv::INTER_AREA);
  cv::cvtColor(small, grey, cv::COLOR_RGB2GRAY);
  const int band = std::max(2, static_cast<int>(std::lround(2 * border_share * kWidth)));
  std::vector<float> signature;
  for (int y = 0; y < grey.rows; ++y)
    for (int x = 0; x < grey.cols; ++x)
      if (y < band || x < band || x >= grey.cols - band)
        signature.push_back(grey.at<std::uint8_t>(y, x));
  return signature;
}

bool SameSurroundings(const std::vector<float>& a, const std::vector<float>& b) {
  constexpr double kLeastCorrelation = 0.97, kLargestChange = 5;
  if (a.size() != b.size()) return false;
  const auto n = static_cast<double>(a.size());
  double ma = 0, mb = 0, aa = 0, bb = 0, ab = 0, change = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    ma += a[k] / n;
    mb += b[k] / n;
    change += std::abs(a[k] - b[k]) / n;
  }
  for (std::size_t k = 0; k < a.size(); ++k) {
    aa += (a[k] - ma) * (a[k] - ma);
    bb += (b[k] - mb) * (b[k] - mb);
    ab += (a[k] - ma) * (b[k] - mb);
  }
  // One grey level of structure is the least for a comparison.
  return change <= kLargestChange && aa > n && bb > n &&
         ab >= kLeastCorrelation * std::sqrt(aa * bb);
}

/// Interpolates the background's colours below the figure: averages over increasingly large cells,
/// taken from the smallest cell that has any.
cv::Mat CarriedIn(const cv::Mat& lab, const cv::Mat& known) {
  constexpr int kSmallestCell = 8;
  cv::Mat weight, values;
  known.convertTo(weight, CV_32F, 1 / 255.0);
  lab.convertTo(values, CV_32F);
  std::vector<cv::Mat> channels(3);
  cv::split(values, channels);
  for (cv::Mat& c : channels) c = c.mul(weight);
  std::vector<cv::Mat> sums, weights;
  for (int cell = kSmallestCell;; cell *= 2) {
    const cv::Size size(std::max(1, lab.cols / cell), std::max(1, lab.rows / cell));
    cv::Mat sum, small_weight, merged;
    cv::merge(channels, merged);
    cv::resize(merged, sum, size, 0, 0, cv::INTER_AREA);
    cv::resize(weight, small_weight, size, 0, 0, cv::INTER_AREA);
    cv::GaussianBlur(sum, sum, {5, 5}, 1);
    cv::GaussianBlur(small_weight, small_weight, {5, 5}, 1);
    sums.push_back(sum);
    weights.push_back(small_weight);
    if (size.width <= 2 || size.height <= 2) break;
  }
  cv::Mat result(sums.back().size(), CV_32FC3, cv::Scalar(128, 128, 128));
  for (std::size_t level = sums.size(); level-- > 0;) {
    cv::resize(result, result, sums[level].size(), 0, 0, cv::INTER_LINEAR);
    for (int y = 0; y < result.rows; ++y)
      for (int x = 0; x < result.cols; ++x) {
        const float w = weights[level].at<float>(y, x), share = std::min(1.0F, 4 * w);
        if (w < 1e-4F) continue;
        cv::Vec3f& r = result.at<cv::Vec3f>(y, x);
        r = r * (1 - share) + sums[level].at<cv::Vec3f>(y, x) * (share / w);
      }
  }
  cv::resize(result, result, lab.size(), 0, 0, cv::INTER_LINEAR);
  result.convertTo(result, CV_8U);
  return result;
}

/// The other photographs of a take, evenly spread, for a median.
std::vector<std::size_t> OthersOf(const Take& take, std::size_t i) {
  std::vector<std::size_t> all = take.images;
  std::erase(all, i);
  std::vector<std::size_t> some;
  const std::size_t count = std::min(kMostOfTake, all.size());
  for (std::size_t k = 0; k < count; ++k) some.push_back(all[k * all.size() / count]);
  return some;
}

/// Medians of many small sets at once, byte by byte: the largest value with at most half of the set
/// below it, found bit by bit. Loops over the bytes are vectorised; a selection for each pixel
/// takes ten times as long.
/// @param rows    each has one value of every set; 255 where it has none
/// @param counts  number of values in each set
std::vector<std::uint8_t> Medians(const std::vector<std::vector<std::uint8_t>>& rows,
                                  const std::vector<std::uint8_t>& counts) {
  const std::size_t n = counts.size();
  std::vector<std::uint8_t> medians(n, 0), below(n);
  for (int bit = 128; bit > 0; bit /= 2) {
    std::fill(below.begin(), below.end(), std::uint8_t{0});
    const auto b = static_cast<std::uint8_t>(bit);
    for (const std::vector<std::uint8_t>& row : rows)
      for (std::size_t j = 0; j < n; ++j)
        below[j] = static_cast<std::uint8_t>(below[j] + (row[j] < (medians[j] | b)));
    for (std::size_t j = 0; j < n; ++j)
      medians[j] = static_cast<std::uint8_t>(medians[j] | (below[j] <= counts[j] / 2 ? b : 0));
  }
  return medians;
}

std::uint8_t Level(double value) {
  return static_cast<std::uint8_t>(std::clamp(value, 0.0, kFeatureLevels - 1.0));
}

/// A difference of 8 bit Lab, with finer levels for small differences.
std::uint8_t Difference(double value, double scale) {
  return Level(kFeatureLevels / 2.0 + std::copysign(std::sqrt(std::abs(value)), value) * scale);
}

/// Standard deviation of lightness in a window.
cv::Mat Contrast(const cv::Mat& light, int window) {
  cv::Mat mean, mean_square, contrast;
  cv::boxFilter(light, mean, CV_32F, {window, window});
  cv::boxFilter(light.mul(light), mean_square, CV_32F, {window, window});
  cv::sqrt(cv::max(mean_square - mean.mul(mean), 0), contrast);
  return contrast;
}

cv::Mat SmoothDifference(const cv::Mat& lab, const cv::Mat& empty, int window) {
  cv::Mat difference, smooth;
  cv::subtract(lab, empty, difference, cv::noArray(), CV_32FC3);
  cv::boxFilter(difference, smooth, CV_32F, {window, window});
  return smooth;
}

}  // namespace

const Take& TakeOf(const std::vector<Take>& takes, std::size_t i) {
  return *std::find_if(takes.begin(), takes.end(), [i](const Take& take) {
    return std::binary_search(take.images.begin(), take.images.end(), i);
  });
}

std::vector<Take> FindTakes(const std::vector<Image8>& images, double border_share) {
  std::map<std::pair<int, int>, std::vector<std::size_t>> by_size;
  for (std::size_t i = 0; i < images.size(); ++i)
    by_size[{images[i].width, images[i].height}].push_back(i);
  std::vector<Take> takes;
  for (const auto& [size, of_size] : by_size) {
    std::vector<float> first, last;
    for (const std::size_t i : of_size) {
      std::vector<float> here = BorderSignature(images[i], border_share);
      if (first.empty() || !SameSurroundings(here, last) || !SameSurroundings(here, first)) {
        takes.emplace_back();
        first = here;
      }
      takes.back().images.push_back(i);
      last = std::move(here);
    }
  }
  return takes;
}

Image8 EmptySet(const std::vector<Image8>& lab, const std::vector<Image8>& trimaps,
                const Take& take, std::size_t i) {
  cv::Mat empty = CarriedIn(MatOf(lab[i]), MatOf(trimaps[i]) == kBackground);
  const std::vector<std::size_t> others = OthersOf(take, i);
  if (others.size() < kLeastOfTake) return ImageOf(empty);
  const auto width = static_cast<std::size_t>(empty.cols);
  std::vector<std::vector<std::uint8_t>> rows(others.size(), std::vector<std::uint8_t>(3 * width));
  std::vector<std::uint8_t> counts(3 * width);
  for (int y = 0; y < empty.rows; ++y) {
    std::fill(counts.begin(), counts.end(), std::uint8_t{0});
    for (std::size_t k = 0; k < others.size(); ++k) {
      const std::uint8_t *label = trimaps[others[k]].at(0, y), *pixels = lab[others[k]].at(0, y);
      for (std::size_t j = 0; j < 3 * width; ++j) {
        const bool background = label[j / 3] == kBackground;
        rows[k][j] = background ? pixels[j] : 255;
        counts[j] = static_cast<std::uint8_t>(counts[j] + background);
      }
    }
    const std::vector<std::uint8_t> medians = Medians(rows, counts);
    for (std::size_t j = 0; j < 3 * width; ++j)
      if (counts[j] >= kLeastOfTake) empty.ptr<std::uint8_t>(y)[j] = medians[j];
  }
  return ImageOf(empty);
}

Image8 LabOf(const Image8& rgb) {
  cv::Mat lab;
  cv::cvtColor(MatOf(rgb), lab, cv::COLOR_RGB2Lab);
  return ImageOf(lab);
}

std::vector<PixelFeatures> FeaturesOf(const Image8& lab, const Image8& empty_lab) {
  const cv::Mat smooth = SmoothDifference(MatOf(lab), MatOf(empty_lab), 5);
  cv::Mat light;
  cv::extractChannel(MatOf(lab), light, 0);
  light.convertTo(light, CV_32F);
  const cv::Mat fine = Contrast(light, 5), coarse = Contrast(light, 11);
  std::vector<PixelFeatures> features(static_cast<std::size_t>(lab.width) * lab.height);
  for (int y = 0; y < lab.height; ++y)
    for (int x = 0; x < lab.width; ++x) {
      const std::uint8_t *here = lab.at(x, y), *empty = empty_lab.at(x, y);
      const cv::Vec3f& even = smooth.at<cv::Vec3f>(y, x);
      PixelFeatures& f = features[static_cast<std::size_t>(y) * lab.width + x];
      f[0] = Level(here[0] / 4);
      for (std::size_t c = 1; c < 3; ++c) f[c] = Level(32 + (here[c] - 128) / 2);
      for (std::size_t c = 0; c < 3; ++c) {
        f[3 + c] = Difference(here[c] - empty[c], c == 0 ? 2.2 : 4);
        f[6 + c] = Difference(even[static_cast<int>(c)], c == 0 ? 2.2 : 4);
      }
      f[9] = Level(10 * std::log2(1 + fine.at<float>(y, x)));
      f[10] = Level(10 * std::log2(1 + coarse.at<float>(y, x)));
    }
  return features;
}

std::vector<PixelFeatures> WithoutEmptySet(std::vector<PixelFeatures> features) {
  for (PixelFeatures& f : features) std::fill(f.begin() + 3, f.begin() + 9, std::uint8_t{0});
  return features;
}

double Misfit(const Image8& lab, const Image8& empty_lab, const Image8& trimap) {
  double sum = 0, count = 0;
  for (int y = 0; y < lab.height; ++y)
    for (int x = 0; x < lab.width; ++x) {
      if (*trimap.at(x, y) != kBackground) continue;
      const double difference = *lab.at(x, y) - *empty_lab.at(x, y);
      sum += difference * difference;
      count += 1;
    }
  return count > 0 ? std::sqrt(sum / count) : 0;
}

std::array<int, 3> UsualDifference(const Image8& lab, const Image8& empty_lab,
                                   const Image8& trimap) {
  constexpr double kUsual = 0.95;
  constexpr int kSlack = 1;
  std::array<int, 3> usual{};
  for (std::size_t c = 0; c < 3; ++c) {
    std::array<std::size_t, 256> count{};
    std::size_t all = 0;
    for (std::size_t p = 0; p < trimap.data.size(); ++p)
      if (trimap.data[p] == kBackground) {
        ++count[std::abs(lab.data[3 * p + c] - empty_lab.data[3 * p + c])];
        ++all;
      }
    std::size_t below = count[0];
    while (usual[c] < 255 && static_cast<double>(below) < kUsual * static_cast<double>(all))
      below += count[++usual[c]];
    usual[c] += kSlack;
  }
  return usual;
}

Image8 ShadowKinds(const Image8& lab, const Image8& empty_lab) {
  const cv::Mat smooth = SmoothDifference(MatOf(lab), MatOf(empty_lab), 5);
  cv::Mat light;
  cv::extractChannel(MatOf(lab), light, 0);
  light.convertTo(light, CV_32F);
  const cv::Mat contrast = Contrast(light, 5);
  constexpr double kLargestHue = 4, kLargestContrast = 6,
                   kLeastLight = 0.3;  // of 8 bit Lab; of the empty set's lightness
  Image8 kinds(lab.width, lab.height, 1, 0);
  for (int y = 0; y < lab.height; ++y)
    for (int x = 0; x < lab.width; ++x) {
      const cv::Vec3f& d = smooth.at<cv::Vec3f>(y, x);
      const std::uint8_t* e = empty_lab.at(x, y);
      const double left = (e[0] + d[0]) / std::max<double>(e[0], 1);
      // Chroma decreases with light, so a shadow's expected chroma is the empty set's, reduced.
      const double hue =
          std::hypot(d[1] + (1 - left) * (e[1] - 128), d[2] + (1 - left) * (e[2] - 128));
      if (d[0] > -3 || left <= kLeastLight || left >= 1 || hue >= kLargestHue ||
          contrast.at<float>(y, x) >= kLargestContrast)
        continue;
      const int dark = static_cast<int>(8 * (left - kLeastLight) / (1 - kLeastLight)),
                other = hue >= kLargestHue / 2;
      const int rough = static_cast<int>(3 * contrast.at<float>(y, x) / kLargestContrast);
      *kinds.at(x, y) =
          static_cast<std::uint8_t>(1 + (std::min(dark, 7) * 2 + other) * 3 + std::min(rough, 2));
    }
  return kinds;
}

}  // namespace keypose::capture
