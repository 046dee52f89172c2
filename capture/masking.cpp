#include "capture/masking.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/imgproc/detail/gcgraph.hpp>
#include <opencv2/ximgproc/edge_filter.hpp>
#include <string>

#include "capture/zone_odds.h"
#include "core/errors.h"
#include "core/parallel.h"

namespace keypose::capture {
namespace {

cv::Mat View(const Image8& image) {
  return cv::Mat(image.height, image.width, CV_8UC(image.channels), const_cast<std::uint8_t*>(image.data.data()));
}

Image8 FromMat(const cv::Mat& mat) {
  Image8 image(mat.cols, mat.rows, mat.channels());
  mat.copyTo(View(image));
  return image;
}

/// Before anything is known: a band along the borders, and an ellipse in the middle.
Image8 FirstZones(int width, int height, double border_share) {
  Image8 zones(width, height, 1, kNeither);
  const int band = std::max(2, static_cast<int>(border_share * std::max(width, height)));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double dx = (x + 0.5) / width - 0.5, dy = (y + 0.5) / height - 0.5;
      if (x < band || y < band || x >= width - band || y >= height - band) *zones.at(x, y) = kBackground;
      if (dx * dx + dy * dy < 0.25 * 0.25) *zones.at(x, y) = kObject;
    }
  return zones;
}

/// The last round's mask as zones; the pixels at its border, which mix both, belong to neither.
Image8 ZonesOf(const Image8& mask) {
  const cv::Mat kernel = cv::getStructuringElement(cv::MORPH_ELLIPSE, {5, 5});
  cv::Mat inside, outside;
  cv::erode(View(mask), inside, kernel);
  cv::dilate(View(mask), outside, kernel);
  cv::Mat zones(inside.size(), CV_8U, cv::Scalar(kNeither));
  zones.setTo(kObject, inside);
  zones.setTo(kBackground, outside == 0);
  return FromMat(zones);
}

/// Log odds from the difference to the empty set.
ImageF PlateOdds(const Image8& image, const Image8& plate, const MaskOptions& options) {
  cv::Mat a, b;
  cv::cvtColor(View(image), a, cv::COLOR_RGB2Lab);
  cv::cvtColor(View(plate), b, cv::COLOR_RGB2Lab);
  ImageF odds(image.width, image.height, 1);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const cv::Vec3b p = a.at<cv::Vec3b>(y, x), q = b.at<cv::Vec3b>(y, x);
      const double light = (p[0] - q[0]) * (100.0 / 255), da = p[1] - q[1], db = p[2] - q[2];
      // A cast shadow darkens and hardly changes hue: darkening by up to a half counts a third.
      const double weight = light < 0 && p[0] > q[0] / 2 ? 1.0 / 9 : 1.0;
      const double difference = std::sqrt(weight * light * light + da * da + db * db);
      *odds.at(x, y) =
          static_cast<float>(std::clamp(4 * (difference / options.plate_difference - 1), -options.odds_limit, options.odds_limit));
    }
  return odds;
}

/// 1 / (2 mean squared colour difference of neighbours), GrabCut's beta.
double Beta(const cv::Mat& image) {
  double sum = 0;
  std::int64_t count = 0;
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) {
      const cv::Vec3d here = image.at<cv::Vec3b>(y, x);
      if (x > 0) sum += cv::norm(here - cv::Vec3d(image.at<cv::Vec3b>(y, x - 1)), cv::NORM_L2SQR), ++count;
      if (y > 0) sum += cv::norm(here - cv::Vec3d(image.at<cv::Vec3b>(y - 1, x)), cv::NORM_L2SQR), ++count;
    }
  return sum <= 0 ? 0 : 1 / (2 * sum / static_cast<double>(count));
}

/// Least cost labelling: odds at pixels, a cost for each pair of unlike neighbours that falls with their colour difference.
cv::Mat GraphCut(const cv::Mat& image, const ImageF& odds, double smoothness) {
  constexpr std::array<std::array<int, 2>, 4> kNeighbors{{{-1, 0}, {0, -1}, {-1, -1}, {1, -1}}};
  const double beta = Beta(image);
  const int pixels = image.rows * image.cols;
  cv::detail::GCGraph<double> graph(static_cast<unsigned>(pixels), static_cast<unsigned>(2 * (4 * pixels)));
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) {
      const int vertex = graph.addVtx();
      const double odd = *odds.at(x, y);
      graph.addTermWeights(vertex, std::max(odd, 0.0), std::max(-odd, 0.0));
      for (const auto& [dx, dy] : kNeighbors) {
        const int nx = x + dx, ny = y + dy;
        if (nx < 0 || ny < 0 || nx >= image.cols) continue;
        const double difference = cv::norm(cv::Vec3d(image.at<cv::Vec3b>(y, x)) - cv::Vec3d(image.at<cv::Vec3b>(ny, nx)), cv::NORM_L2SQR);
        const double weight = smoothness * std::exp(-beta * difference) / (dx != 0 && dy != 0 ? std::sqrt(2.0) : 1.0);
        graph.addEdges(vertex, ny * image.cols + nx, weight, weight);
      }
    }
  graph.maxFlow();
  cv::Mat labels(image.size(), CV_8U);
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) labels.at<std::uint8_t>(y, x) = graph.inSourceSegment(y * image.cols + x) ? 255 : 0;
  return labels;
}

/// The region that weighs most, where pixels count more the nearer they are to the middle.
cv::Mat BestRegion(const cv::Mat& labels) {
  cv::Mat components;
  const int count = cv::connectedComponents(labels, components, 8, CV_32S);
  std::vector<double> weight(static_cast<std::size_t>(count), 0);
  for (int y = 0; y < labels.rows; ++y)
    for (int x = 0; x < labels.cols; ++x) {
      const double dx = (x + 0.5) / labels.cols - 0.5, dy = (y + 0.5) / labels.rows - 0.5;
      weight[static_cast<std::size_t>(components.at<int>(y, x))] += std::exp(-(dx * dx + dy * dy) / (2 * 0.2 * 0.2));
    }
  int best = 0;
  for (int i = 1; i < count; ++i)
    if (best == 0 || weight[static_cast<std::size_t>(i)] > weight[static_cast<std::size_t>(best)]) best = i;
  return best == 0 ? cv::Mat(cv::Mat::zeros(labels.size(), CV_8U)) : cv::Mat(components == best);
}

/// Fills holes unless they are plainly background seen through the object.
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
      const bool see_through = area[c] > 1e-3 * static_cast<double>(mask.total()) && sum[c] < -sure * area[c];
      if (c != 0 && !open[c] && !see_through) mask.at<std::uint8_t>(y, x) = 255;
    }
}

Image8 Segment(const Image8& image, const ImageF& odds, const MaskOptions& options) {
  cv::Mat mask = BestRegion(GraphCut(View(image), odds, options.smoothness));
  FillHoles(mask, odds, options.odds_limit / 2);
  return FromMat(mask);
}

/// On the plate its print decides; colours, which were learned elsewhere (ink looks like dark noses), only lean.
void AddBoard(ImageF& odds, const BoardOdds& board, double limit) {
  if (board.odds.empty()) return;
  for (std::size_t i = 0; i < odds.data.size(); ++i) {
    if (!board.on_board.data[i]) continue;
    const double lean = std::clamp(static_cast<double>(odds.data[i]), -1.5, 1.5);
    odds.data[i] = static_cast<float>(std::clamp(2.0 * board.odds.data[i] + lean, -limit, limit));
  }
}

/// Where the plate is seen nothing is learned: its ink is no colour of the set behind, or a dark nose would pass for background.
void LeaveOutBoard(Image8& zones, const BoardOdds& board) {
  if (board.odds.empty()) return;
  for (std::size_t i = 0; i < zones.data.size(); ++i)
    if (board.on_board.data[i] && board.odds.data[i] < 0) zones.data[i] = kNeither;
}

/// One round over the set: learn from the zones, then segment each image by the set's odds and its own together.
std::vector<Image8> SegmentByZones(const std::vector<Image8>& images, const std::vector<Image8>& zones,
                                   const std::vector<BoardOdds>& boards, const MaskOptions& options) {
  ZoneOdds pooled;
  for (std::size_t i = 0; i < images.size(); ++i) pooled.Add(images[i], zones[i]);
  std::vector<Image8> masks(images.size());
  const float share = 1.0F / static_cast<float>(images.size());
  ParallelFor(static_cast<std::int64_t>(images.size()), [&](std::int64_t k) {
    const auto i = static_cast<std::size_t>(k);
    ZoneOdds odds;
    odds.Add(images[i], zones[i]);
    odds.Add(pooled, share);  // the photograph counts as much as the set
    odds.Finish();
    ImageF known = odds.Of(images[i], options.odds_limit);
    AddBoard(known, boards[i], options.odds_limit);
    masks[i] = Segment(images[i], known, options);
  });
  return masks;
}

std::vector<Image8> SegmentByPlate(const std::vector<Image8>& images, const Image8& plate, const std::vector<BoardOdds>& boards,
                                   const MaskOptions& options) {
  std::vector<Image8> masks(images.size());
  ParallelFor(static_cast<std::int64_t>(images.size()), [&](std::int64_t k) {
    const auto i = static_cast<std::size_t>(k);
    ImageF odds = PlateOdds(images[i], plate, options);
    // The empty set was shot without the printed plate, or with it turned another way.
    for (std::size_t p = 0; p < odds.data.size(); ++p)
      if (!boards[i].odds.empty() && boards[i].on_board.data[p]) odds.data[p] = boards[i].odds.data[p];
    masks[i] = Segment(images[i], odds, options);
  });
  return masks;
}

void RequirePlateFits(const std::vector<Image8>& images, const Image8& plate) {
  for (const Image8& image : images)
    if (image.width != plate.width || image.height != plate.height)
      throw InputError("capture: the background plate has another shape than the photographs (" + std::to_string(plate.width) + " x " +
                       std::to_string(plate.height) + " against " + std::to_string(image.width) + " x " + std::to_string(image.height) +
                       " at working size): photograph the empty set with the same camera settings");
}

}  // namespace

std::vector<Image8> SegmentSet(const std::vector<Image8>& images, const Image8& plate, const std::vector<BoardOdds>& boards,
                               const MaskOptions& options, Progress* progress) {
  cv::setNumThreads(1);  // the loops over images use all cores already
  if (images.empty()) throw InputError("capture: no photographs to mask");
  std::vector<BoardOdds> known = boards;
  known.resize(images.size());
  if (!plate.empty()) {
    RequirePlateFits(images, plate);
    Step(progress, 0, "masks from the background plate");
    return SegmentByPlate(images, plate, known, options);
  }
  std::vector<Image8> zones, masks;
  for (const Image8& image : images) zones.push_back(FirstZones(image.width, image.height, options.border_share));
  for (int round = 0; round < options.rounds; ++round) {
    Step(progress, static_cast<double>(round) / options.rounds, "masks");
    for (std::size_t i = 0; i < zones.size(); ++i) LeaveOutBoard(zones[i], known[i]);
    masks = SegmentByZones(images, zones, known, options);
    for (std::size_t i = 0; i < masks.size(); ++i) zones[i] = ZonesOf(masks[i]);
  }
  return masks;
}

Image8 WorkingImage(const Image8& image, int working_px) {
  const double factor = static_cast<double>(working_px) / std::max(image.width, image.height);
  if (factor >= 1) return image;
  cv::Mat small;
  const cv::Size size(std::max(1, static_cast<int>(std::lround(image.width * factor))),
                      std::max(1, static_cast<int>(std::lround(image.height * factor))));
  cv::resize(View(image), small, size, 0, 0, cv::INTER_AREA);
  return FromMat(small);
}

Image8 RefinedMask(const Image8& image, const Image8& small_mask) {
  if (small_mask.width == image.width && small_mask.height == image.height) return small_mask;
  cv::Mat large, guided;
  cv::resize(View(small_mask), large, {image.width, image.height}, 0, 0, cv::INTER_LINEAR);
  const int radius = std::max(2, 2 * image.width / std::max(1, small_mask.width));
  cv::ximgproc::guidedFilter(View(image), large, guided, radius, 25.0);
  return FromMat(BestRegion(guided > 127));
}

Image8 Grey(const Image8& image) {
  cv::Mat grey;
  cv::cvtColor(View(image), grey, cv::COLOR_RGB2GRAY);
  return FromMat(grey);
}

double MaskFraction(const Image8& mask) {
  std::size_t inside = 0;
  for (const std::uint8_t m : mask.data) inside += m > 127;
  return mask.data.empty() ? 0 : static_cast<double>(inside) / static_cast<double>(mask.data.size());
}

}  // namespace keypose::capture
