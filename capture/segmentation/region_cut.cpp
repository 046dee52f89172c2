#include "capture/segmentation/region_cut.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/imgproc/detail/gcgraph.hpp>
#include <vector>

#include "capture/pictures/cv_image.h"

namespace keypose::capture {
namespace {

/// Squared colour difference: a whole number.
int Difference(const cv::Vec3b& a, const cv::Vec3b& b) {
  int sum = 0;
  for (int c = 0; c < 3; ++c) sum += (a[c] - b[c]) * (a[c] - b[c]);
  return sum;
}
constexpr std::size_t kMostDifference = std::size_t{3} * 255 * 255;

/// 1 / (2 mean squared colour difference of neighbours), GrabCut's beta.
double Beta(const cv::Mat& image) {
  std::int64_t sum = 0;
  std::int64_t count = 0;
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) {
      const cv::Vec3b& here = image.at<cv::Vec3b>(y, x);
      if (x > 0) {
        sum += Difference(here, image.at<cv::Vec3b>(y, x - 1));
        ++count;
      }
      if (y > 0) {
        sum += Difference(here, image.at<cv::Vec3b>(y - 1, x));
        ++count;
      }
    }
  return sum <= 0 ? 0 : 1 / (2 * static_cast<double>(sum) / static_cast<double>(count));
}

/// Cost of a border between neighbours, by their difference; each is computed when it first occurs.
class BorderCost {
 public:
  BorderCost(double beta, double smoothness)
      : beta_(beta), smoothness_(smoothness), known_(kMostDifference + 1, -1) {}
  double Of(int difference) {
    double& cost = known_[static_cast<std::size_t>(difference)];
    if (cost < 0) cost = smoothness_ * std::exp(-beta_ * difference);
    return cost;
  }

 private:
  double beta_, smoothness_;
  std::vector<double> known_;
};

/// Minimum-cost labelling: odds at pixels, and a cost for each pair of differently labelled
/// neighbours that decreases with their colour difference.
cv::Mat GraphCut(const cv::Mat& image, const ImageF& odds, double smoothness) {
  constexpr std::array<std::array<int, 2>, 4> kNeighbors{{{-1, 0}, {0, -1}, {-1, -1}, {1, -1}}};
  BorderCost cost(Beta(image), smoothness);
  const int pixels = image.rows * image.cols;
  cv::detail::GCGraph<double> graph(static_cast<unsigned>(pixels),
                                    static_cast<unsigned>(2 * (4 * pixels)));
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) {
      const int vertex = graph.addVtx();
      const double odd = *odds.at(x, y);
      graph.addTermWeights(vertex, std::max(odd, 0.0), std::max(-odd, 0.0));
      for (const auto& [dx, dy] : kNeighbors) {
        const int nx = x + dx, ny = y + dy;
        if (nx < 0 || ny < 0 || nx >= image.cols) continue;
        const double weight =
            cost.Of(Difference(image.at<cv::Vec3b>(y, x), image.at<cv::Vec3b>(ny, nx))) /
            (dx != 0 && dy != 0 ? std::sqrt(2.0) : 1.0);
        graph.addEdges(vertex, ny * image.cols + nx, weight, weight);
      }
    }
  graph.maxFlow();
  cv::Mat labels(image.size(), CV_8U);
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x)
      labels.at<std::uint8_t>(y, x) = graph.inSourceSegment(y * image.cols + x) ? 255 : 0;
  return labels;
}

/// The region with the largest weight, where a pixel's weight increases towards the middle.
cv::Mat HeaviestRegion(const cv::Mat& labels) {
  cv::Mat components;
  const int count = cv::connectedComponents(labels, components, 8, CV_32S);
  std::vector<double> weight(static_cast<std::size_t>(count), 0);
  for (int y = 0; y < labels.rows; ++y)
    for (int x = 0; x < labels.cols; ++x) {
      if (components.at<int>(y, x) == 0) continue;
      const double dx = (x + 0.5) / labels.cols - 0.5, dy = (y + 0.5) / labels.rows - 0.5;
      weight[components.at<int>(y, x)] += std::exp(-(dx * dx + dy * dy) / (2 * 0.2 * 0.2));
    }
  int best = 0;
  for (int i = 1; i < count; ++i)
    if (best == 0 || weight[i] > weight[best]) best = i;
  return best == 0 ? cv::Mat(cv::Mat::zeros(labels.size(), CV_8U)) : cv::Mat(components == best);
}

/// Fills holes unless they are clearly background behind the object; small holes need larger odds.
// of the picture: smaller holes are treated as if they had this size
constexpr double kLeastHole = 2.5e-4;

void FillHoles(cv::Mat& mask, const ImageF& odds, double sure) {
  cv::Mat components;
  const cv::Mat outside = mask == 0;
  const int count = cv::connectedComponents(outside, components, 4, CV_32S);
  std::vector<double> sum(static_cast<std::size_t>(count), 0), area(sum);
  std::vector<char> open(static_cast<std::size_t>(count), 0);
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x) {
      const auto c = static_cast<std::size_t>(components.at<int>(y, x));
      sum[c] += *odds.at(x, y);
      area[c] += 1;
      if (x == 0 || y == 0 || x == mask.cols - 1 || y == mask.rows - 1) open[c] = 1;
    }
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x) {
      const auto c = static_cast<std::size_t>(components.at<int>(y, x));
      const bool see_through =
          sum[c] < -sure * std::max(area[c], kLeastHole * static_cast<double>(mask.total()));
      if (c != 0 && !open[c] && !see_through) mask.at<std::uint8_t>(y, x) = 255;
    }
}

}  // namespace

Image8 CutRegion(const Image8& image, const ImageF& odds, double smoothness, double sure) {
  cv::Mat mask = HeaviestRegion(GraphCut(MatOf(image), odds, smoothness));
  FillHoles(mask, odds, sure);
  return ImageOf(mask);
}

Image8 CutRegions(const Image8& image, const ImageF& odds, double smoothness, double sure) {
  cv::Mat mask = GraphCut(MatOf(image), odds, smoothness);
  FillHoles(mask, odds, sure);
  return ImageOf(mask);
}

Image8 CutLabels(const Image8& image, const ImageF& odds, double smoothness) {
  return ImageOf(GraphCut(MatOf(image), odds, smoothness));
}

void FillUnclearHoles(Image8& mask, const ImageF& odds, double sure) {
  cv::Mat view = MatOf(mask);
  FillHoles(view, odds, sure);
}

Image8 BestRegion(const Image8& mask) { return ImageOf(HeaviestRegion(MatOf(mask))); }

}  // namespace keypose::capture
