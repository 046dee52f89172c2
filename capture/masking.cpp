#include "capture/masking.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/ximgproc/edge_filter.hpp>
#include <string>

#include "capture/cv_image.h"
#include "capture/empty_set.h"
#include "capture/gaps.h"
#include "capture/mask_edge.h"
#include "capture/region_cut.h"
#include "capture/set_rounds.h"
#include "capture/zone_odds.h"
#include "core/errors.h"
#include "core/parallel.h"

namespace keypose::capture {
namespace {

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

/// Log odds from the difference to the empty set.
ImageF PlateOdds(const Image8& image, const Image8& plate, const MaskOptions& options) {
  cv::Mat a, b;
  cv::cvtColor(MatOf(image), a, cv::COLOR_RGB2Lab);
  cv::cvtColor(MatOf(plate), b, cv::COLOR_RGB2Lab);
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

constexpr int kColorRounds = 2;  // a forest needs zones that are nearly right

/// Where the plate is seen nothing is learned: its ink is no colour of the set behind, or a dark nose would pass for background.
void LeaveOutBoard(Image8& zones, const BoardOdds& board) {
  if (board.odds.empty()) return;
  for (std::size_t i = 0; i < zones.data.size(); ++i)
    if (board.on_board.data[i] && board.odds.data[i] < 0) zones.data[i] = kNeither;
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
    masks[i] = CutRegion(images[i], odds, options.smoothness, options.odds_limit / 2);
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
  // Rounds but the last at half the size: they only teach.
  std::vector<Image8> small;
  for (const Image8& image : images) small.push_back(WorkingImage(image, std::max(image.width, image.height) / 2));
  Round coarse{small, {}, {}, {}, nullptr, {}};
  for (const Image8& image : small) {
    coarse.lab.push_back(LabOf(image));
    coarse.zones.push_back(FirstZones(image.width, image.height, options.border_share));
  }
  coarse.takes = FindTakes(small, options.border_share);
  const std::vector<BoardOdds> small_boards = Halved(known, small);
  for (int round = 0; round + 1 < options.rounds; ++round) {
    Step(progress, static_cast<double>(round) / options.rounds, "masks");
    for (std::size_t i = 0; i < small.size(); ++i) LeaveOutBoard(coarse.zones[i], small_boards[i]);
    const std::vector<Image8> masks =
        round < kColorRounds ? SegmentByColor(small, coarse.zones, small_boards, options) : SegmentByForest(coarse, small_boards, options);
    for (std::size_t i = 0; i < masks.size(); ++i) coarse.zones[i] = ZonesOf(masks[i]);
  }
  Step(progress, static_cast<double>(options.rounds - 1) / options.rounds, "masks");
  Round fine{images, {}, {}, coarse.takes, nullptr, {}};
  for (std::size_t i = 0; i < images.size(); ++i) {
    fine.lab.push_back(LabOf(images[i]));
    fine.zones.push_back(Enlarged(coarse.zones[i], images[i].width, images[i].height));
    LeaveOutBoard(fine.zones[i], known[i]);
  }
  return SegmentByForest(fine, known, options);
}

Image8 WorkingImage(const Image8& image, int working_px) {
  const double factor = static_cast<double>(working_px) / std::max(image.width, image.height);
  if (factor >= 1) return image;
  cv::Mat small;
  const cv::Size size(std::max(1, static_cast<int>(std::lround(image.width * factor))),
                      std::max(1, static_cast<int>(std::lround(image.height * factor))));
  cv::resize(MatOf(image), small, size, 0, 0, cv::INTER_AREA);
  return ImageOf(small);
}

Image8 RefinedMask(const Image8& image, const Image8& small_mask, const Backdrop* backdrop) {
  if (small_mask.width == image.width && small_mask.height == image.height) {
    Image8 settled = small_mask;
    if (backdrop) OpenGaps(image, *backdrop, settled);
    SettleEdge(image, settled);
    return BestRegion(settled);
  }
  cv::Mat large, guided;
  cv::resize(MatOf(small_mask), large, {image.width, image.height}, 0, 0, cv::INTER_LINEAR);
  const int radius = std::max(2, 2 * image.width / std::max(1, small_mask.width));
  // The filter asks for some thirty planes of floats. Two radii beyond the mask it gives zero whatever the picture, so it sees no more
  // than its surroundings.
  const int margin = 4 * radius;
  cv::Rect box = cv::boundingRect(large);
  if (box.empty()) return BestRegion(ImageOf(large));
  box = cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) & cv::Rect({0, 0}, large.size());
  cv::ximgproc::guidedFilter(MatOf(image)(box).clone(), large(box).clone(), guided, radius, 25.0);
  cv::Mat mask = cv::Mat::zeros(large.size(), CV_8U);
  mask(box).setTo(255, guided > 127);
  Image8 settled = ImageOf(mask);
  if (backdrop) OpenGaps(image, *backdrop, settled);
  SettleEdge(image, settled);
  return BestRegion(settled);
}

Image8 Grey(const Image8& image) {
  cv::Mat grey;
  cv::cvtColor(MatOf(image), grey, cv::COLOR_RGB2GRAY);
  return ImageOf(grey);
}

double MaskFraction(const Image8& mask) {
  std::size_t inside = 0;
  for (const std::uint8_t m : mask.data) inside += m > 127;
  return mask.data.empty() ? 0 : static_cast<double>(inside) / static_cast<double>(mask.data.size());
}

}  // namespace keypose::capture
