#include "capture/pictures/strangers.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "capture/pictures/cv_image.h"
#include "capture/pictures/overlap.h"
#include "capture/pictures/working_image.h"
#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/values/tuned.h"

namespace keypose::capture {
namespace {

using Indices = std::vector<std::size_t>;

constexpr int kSketch_px = 96;
constexpr int kLightnesses = 10, kTints = 16;  // bins
constexpr int kTints_from = 64, kTints_range = 128;

/// Tuned on shared/data/photos (rings, thinned rings of 6 to 13, and their photographs in each
/// other's sets) and on `keypose synth photos` and `room`.
struct StrangerTuning {
  /// distance of the middles' colours that one thing's neighbours do not reach
  KEYPOSE_TUNED(double, kMiddle, 0.56);
  /// the same of colours that the border has less of
  KEYPOSE_TUNED(double, kOwn, 0.75);
  /// shares of a middle that are its own below which there is none to compare
  KEYPOSE_TUNED(double, kLeastOwn, 0.05);
  /// times the middle link of the set's own chain: what is nearer belongs to it
  KEYPOSE_TUNED(double, kLinks, 1.6);
  /// px, of pictures of 512: places that move less may be of a still background
  KEYPOSE_TUNED(double, kStill_px, 2);
  /// largest mean difference of a view that was saved twice, levels
  KEYPOSE_TUNED(double, kSame, 1.5);
  /// and over what a photograph differs from the nearest other one
  KEYPOSE_TUNED(double, kSameShare, 0.33);
};

/// The ellipse that the figure is in.
cv::Mat MiddleOf(const cv::Size& size) {
  cv::Mat middle(size, CV_8U, cv::Scalar(0));
  cv::ellipse(middle, cv::Point(size.width / 2, size.height / 2),
              cv::Size(3 * size.width / 10, 7 * size.height / 20), 0, 0, 360, cv::Scalar(255), -1);
  return middle;
}

cv::Mat BorderOf(const cv::Size& size) {
  cv::Mat border(size, CV_8U, cv::Scalar(255));
  const int x = size.width / 7, y = size.height / 7;
  border(cv::Rect(x, y, size.width - 2 * x, size.height - 2 * y)) = 0;
  return border;
}

/// Adds a pixel's eight shares.
void AddColour(const cv::Vec3b& lab, std::vector<float>* bins) {
  const int counts[3] = {kLightnesses, kTints, kTints};
  const float places[3] = {lab[0] / 255.0F * (kLightnesses - 1),
                           static_cast<float>(lab[1] - kTints_from) / kTints_range * (kTints - 1),
                           static_cast<float>(lab[2] - kTints_from) / kTints_range * (kTints - 1)};
  int low[3];
  float above[3];
  for (int c = 0; c < 3; ++c) {
    const float place = std::clamp(places[c], 0.0F, static_cast<float>(counts[c] - 1));
    low[c] = std::min(static_cast<int>(place), counts[c] - 2);
    above[c] = place - static_cast<float>(low[c]);
  }
  for (int corner = 0; corner < 8; ++corner) {
    int bin = 0;
    float share = 1;
    for (int c = 0; c < 3; ++c) {
      const int up = corner >> c & 1;
      bin = bin * counts[c] + low[c] + up;
      share *= up ? above[c] : 1 - above[c];
    }
    (*bins)[static_cast<std::size_t>(bin)] += share;
  }
}

ColourShares SharesIn(const cv::Mat& lab, const cv::Mat& where) {
  std::vector<float> bins(static_cast<std::size_t>(kLightnesses) * kTints * kTints, 0);
  for (int y = 0; y < lab.rows; ++y)
    for (int x = 0; x < lab.cols; ++x)
      if (where.at<std::uint8_t>(y, x)) AddColour(lab.at<cv::Vec3b>(y, x), &bins);
  const auto pixels = static_cast<float>(std::max(1, cv::countNonZero(where)));
  ColourShares shares;
  for (std::size_t bin = 0; bin < bins.size(); ++bin)
    if (bins[bin] > 0) shares.emplace_back(static_cast<int>(bin), bins[bin] / pixels);
  return shares;
}

/// Calls body(of the first, of the second) for each colour that one of them has.
template <class Body>
void ForBoth(const ColourShares& first, const ColourShares& second, const Body& body) {
  auto a = first.begin(), b = second.begin();
  while (a != first.end() || b != second.end()) {
    const int next = std::min(a == first.end() ? std::numeric_limits<int>::max() : a->first,
                              b == second.end() ? std::numeric_limits<int>::max() : b->first);
    const float of_a = a != first.end() && a->first == next ? (a++)->second : 0,
                of_b = b != second.end() && b->first == next ? (b++)->second : 0;
    body(next, of_a, of_b);
  }
}

double SharedShare(const ColourShares& first, const ColourShares& second) {
  double shared = 0;
  ForBoth(first, second, [&](int, float a, float b) { shared += std::min(a, b); });
  return shared;
}

/// Distances of all pairs.
class Distances {
 public:
  explicit Distances(const std::vector<ColourSketch>& sketches)
      : count_(sketches.size()), values_(count_ * count_, 0) {
    ParallelFor(
        static_cast<std::int64_t>(count_),
        [&](std::int64_t i) {
          for (std::size_t j = 0; j < count_; ++j)
            values_[static_cast<std::size_t>(i) * count_ + j] =
                static_cast<float>(Unlikeness(sketches[i], sketches[j]));
        },
        4);
  }
  std::size_t count() const { return count_; }
  double at(std::size_t i, std::size_t j) const { return values_[i * count_ + j]; }

 private:
  std::size_t count_;
  std::vector<float> values_;
};

/// The links of the shortest tree through all of them (Prim's algorithm).
std::vector<ImageTie> ShortestTree(const Distances& distances, std::vector<double>* lengths) {
  const std::size_t count = distances.count();
  std::vector<double> nearest(count, std::numeric_limits<double>::infinity());
  std::vector<std::size_t> by(count, 0);
  std::vector<char> in(count, 0);
  std::vector<ImageTie> links;
  std::size_t last = 0;
  in[0] = 1;
  for (std::size_t step = 1; step < count; ++step) {
    std::size_t next = count;
    for (std::size_t i = 0; i < count; ++i) {
      if (in[i]) continue;
      if (distances.at(last, i) < nearest[i]) {
        nearest[i] = distances.at(last, i);
        by[i] = last;
      }
      if (next == count || nearest[i] < nearest[next]) next = i;
    }
    links.push_back({static_cast<int>(by[next]), static_cast<int>(next), 0});
    lengths->push_back(nearest[next]);
    in[next] = 1;
    last = next;
  }
  return links;
}

/// Links that are no longer than different things are apart, or than the set's own chain.
std::vector<ImageTie> LinksByColour(const Distances& distances) {
  std::vector<double> lengths;
  const std::vector<ImageTie> all = ShortestTree(distances, &lengths);
  const double limit = std::max(1.0, StrangerTuning::kLinks * UpperMedian(lengths));
  std::vector<ImageTie> links;
  for (std::size_t k = 0; k < all.size(); ++k)
    if (lengths[k] <= limit) links.push_back(all[k]);
  return links;
}

/// For each photograph outside of the largest group, those of other groups that are most like it.
std::vector<ImageTie> PairsToMatch(const std::vector<std::vector<int>>& groups,
                                   const Distances& distances) {
  constexpr std::size_t kMost = 40;
  std::vector<std::size_t> group_of(distances.count());
  for (std::size_t g = 0; g < groups.size(); ++g)
    for (const int i : groups[g]) group_of[static_cast<std::size_t>(i)] = g;
  std::vector<ImageTie> pairs;
  for (std::size_t i = 0; i < distances.count(); ++i) {
    if (group_of[i] == 0) continue;
    Indices others;
    for (std::size_t j = 0; j < distances.count(); ++j)
      if (group_of[j] < group_of[i]) others.push_back(j);
    const std::size_t most = std::min(kMost, others.size());
    std::partial_sort(others.begin(), others.begin() + static_cast<std::ptrdiff_t>(most),
                      others.end(), [&](std::size_t a, std::size_t b) {
                        return std::pair(distances.at(i, a), a) < std::pair(distances.at(i, b), b);
                      });
    for (std::size_t k = 0; k < most; ++k)
      pairs.push_back({static_cast<int>(others[k]), static_cast<int>(i), 0});
  }
  return pairs;
}

/// Previews of those photographs that are in pairs; the others stay empty.
std::vector<Preview> PreviewsFor(const std::vector<Image8>& pictures,
                                 const std::vector<Image8>& prints,
                                 const std::vector<ImageTie>& pairs) {
  std::vector<char> wanted(pictures.size(), 0);
  for (const ImageTie& pair : pairs)
    wanted[static_cast<std::size_t>(pair.first)] = wanted[static_cast<std::size_t>(pair.second)] =
        1;
  std::vector<Preview> previews(pictures.size());
  for (std::size_t i = 0; i < pictures.size(); ++i)
    if (wanted[i]) {
      cv::Mat middle = MiddleOf(cv::Size(pictures[i].width, pictures[i].height));
      if (!prints.empty() && !prints[i].empty()) middle.setTo(0, MatOf(prints[i]));
      previews[i] = {Grey(pictures[i]), ImageOf(middle)};
    }
  return previews;
}

/// Mean difference of two pictures of one size, without that of their brightness.
double DifferenceOf(const cv::Mat& first, const cv::Mat& second) {
  cv::Mat difference;
  cv::subtract(first, second, difference);
  const cv::Scalar usual = cv::mean(difference);
  cv::subtract(difference, usual, difference);
  const cv::Scalar mean = cv::mean(cv::abs(difference));
  return (mean[0] + mean[1] + mean[2]) / 3;
}

}  // namespace

ColourSketch SketchOf(const Image8& picture, const Image8& print) {
  const Image8 small = WorkingImage(picture, kSketch_px);
  cv::Mat lab;
  cv::cvtColor(MatOf(small), lab, cv::COLOR_RGB2Lab);
  ColourSketch sketch;
  cv::Mat middle = MiddleOf(lab.size()), border = BorderOf(lab.size());
  if (!print.empty()) {
    const Image8 reduced = WorkingImage(print, kSketch_px);
    const cv::Mat shows = MatOf(reduced) > 127;
    middle.setTo(0, shows);
    border.setTo(0, shows);
  }
  sketch.middle = SharesIn(lab, middle);
  sketch.border = SharesIn(lab, border);
  ForBoth(sketch.middle, sketch.border, [&](int colour, float in, float around) {
    if (in <= around) return;
    sketch.own.emplace_back(colour, in - around);
    sketch.own_share += in - around;
  });
  return sketch;
}

double Unlikeness(const ColourSketch& first, const ColourSketch& second) {
  const double middles = (1 - SharedShare(first.middle, second.middle)) / StrangerTuning::kMiddle;
  const double larger = std::max(first.own_share, second.own_share);
  if (larger < StrangerTuning::kLeastOwn) return middles;
  constexpr double kFaint = 0.1;  // of less, noise would be compared
  const double own = 1 - SharedShare(first.own, second.own) / std::max(larger, kFaint);
  return std::max(middles, own / StrangerTuning::kOwn);
}

std::vector<std::vector<std::size_t>> ThingsShown(const std::vector<Image8>& pictures,
                                                  const std::vector<ColourSketch>& sketches,
                                                  const std::vector<Image8>& prints,
                                                  Progress* progress) {
  std::vector<std::vector<int>> groups;
  if (!pictures.empty()) {
    const Distances distances(sketches);
    const auto count = static_cast<int>(pictures.size());
    std::vector<ImageTie> links = LinksByColour(distances);
    groups = JoinedImages(count, links);
    if (groups.size() > 1) {
      const std::vector<ImageTie> pairs = PairsToMatch(groups, distances);
      const std::vector<ImageTie> ties = SharedPlaces(PreviewsFor(pictures, prints, pairs), pairs,
                                                      StrangerTuning::kStill_px, progress);
      links.insert(links.end(), ties.begin(), ties.end());
      groups = JoinedImages(count, links);
    }
  }
  std::vector<std::vector<std::size_t>> things;
  for (const std::vector<int>& group : groups) things.emplace_back(group.begin(), group.end());
  return things;
}

std::vector<std::pair<std::size_t, std::size_t>> SameViews(
    const std::vector<Image8>& pictures, const std::vector<ColourSketch>& sketches) {
  constexpr double kAlike = 0.25;  // a view saved twice has some 0.02
  std::vector<cv::Mat> small(pictures.size());
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const Image8 sketch = WorkingImage(pictures[i], kSketch_px);
    MatOf(sketch).convertTo(small[i], CV_32FC3);
  }
  std::vector<double> nearest(pictures.size(), std::numeric_limits<double>::infinity());
  std::vector<std::pair<std::size_t, std::size_t>> same;
  std::vector<double> differences;
  for (std::size_t i = 0; i < pictures.size(); ++i)
    for (std::size_t j = i + 1; j < pictures.size(); ++j) {
      if (small[i].size() != small[j].size() || Unlikeness(sketches[i], sketches[j]) > kAlike)
        continue;
      const double difference = DifferenceOf(small[i], small[j]);
      nearest[i] = std::min(nearest[i], difference);
      nearest[j] = std::min(nearest[j], difference);
      if (difference > StrangerTuning::kSame) continue;
      same.emplace_back(i, j);
      differences.push_back(difference);
    }
  if (same.empty()) return same;
  const double limit = StrangerTuning::kSameShare * UpperMedian(nearest);
  std::size_t kept = 0;
  for (std::size_t k = 0; k < same.size(); ++k)
    if (differences[k] < limit) same[kept++] = same[k];
  same.resize(kept);
  return same;
}

}  // namespace keypose::capture
