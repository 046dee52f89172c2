#include "capture/segmentation/masking.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <opencv2/imgproc.hpp>
#include <string>

#include "capture/pictures/cv_image.h"
#include "capture/pictures/working_image.h"
#include "capture/segmentation/boundary_matting.h"
#include "capture/segmentation/colour_odds.h"
#include "capture/segmentation/empty_set.h"
#include "capture/segmentation/guided_border.h"
#include "capture/segmentation/guided_filter.h"
#include "capture/segmentation/mask_holes.h"
#include "capture/segmentation/region_cut.h"
#include "capture/segmentation/set_rounds.h"
#include "core/numbers/parallel.h"
#include "core/values/errors.h"

namespace keypose::capture {
namespace {

/// The initial trimap: a band along the borders, and an ellipse in the middle.
Image8 FirstTrimap(int width, int height, double border_share) {
  Image8 trimap(width, height, 1, kUnknown);
  const int band = std::max(2, static_cast<int>(border_share * std::max(width, height)));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double dx = (x + 0.5) / width - 0.5, dy = (y + 0.5) / height - 0.5;
      if (x < band || y < band || x >= width - band || y >= height - band)
        *trimap.at(x, y) = kBackground;
      if (dx * dx + dy * dy < 0.25 * 0.25) *trimap.at(x, y) = kObject;
    }
  return trimap;
}

/// Log odds from the difference to the empty set.
ImageF CleanPlateOdds(const Image8& image, const Image8& clean_plate, const MaskOptions& options) {
  cv::Mat a, b;
  cv::cvtColor(MatOf(image), a, cv::COLOR_RGB2Lab);
  cv::cvtColor(MatOf(clean_plate), b, cv::COLOR_RGB2Lab);
  ImageF odds(image.width, image.height, 1);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const cv::Vec3b p = a.at<cv::Vec3b>(y, x), q = b.at<cv::Vec3b>(y, x);
      const double light = (p[0] - q[0]) * (100.0 / 255), da = p[1] - q[1], db = p[2] - q[2];
      // A cast shadow darkens and hardly changes hue: darkening by up to a half has a third of the
      // weight.
      const double weight = light < 0 && p[0] > q[0] / 2 ? 1.0 / 9 : 1.0;
      const double difference = std::sqrt(weight * light * light + da * da + db * db);
      *odds.at(x, y) =
          static_cast<float>(std::clamp(4 * (difference / options.clean_plate_difference - 1),
                                        -options.odds_limit, options.odds_limit));
    }
  return odds;
}

// colour rounds come first, because a classifier needs trimaps that are nearly right
constexpr int kColorRounds = 2;

/// Pixels of the calibration board are not used for learning: its ink is no colour of the
/// background, and a dark nose would be classified as background.
void LeaveOutBoard(Image8& trimap, const BoardOdds& board) {
  if (board.odds.empty()) return;
  for (std::size_t i = 0; i < trimap.data.size(); ++i)
    if (board.on_board.data[i] && board.odds.data[i] < 0) trimap.data[i] = kUnknown;
}

std::vector<Image8> SegmentByCleanPlate(const std::vector<Image8>& images,
                                        const Image8& clean_plate,
                                        const std::vector<BoardOdds>& boards,
                                        const MaskOptions& options,
                                        const std::vector<char>& all_regions) {
  std::vector<Image8> masks(images.size());
  ParallelFor(std::ssize(images), [&](std::int64_t k) {
    const auto i = static_cast<std::size_t>(k);
    ImageF odds = CleanPlateOdds(images[i], clean_plate, options);
    // The empty set was shot without the calibration board, or with the board in another position.
    for (std::size_t p = 0; p < odds.data.size(); ++p)
      if (!boards[i].odds.empty() && boards[i].on_board.data[p])
        odds.data[p] = boards[i].odds.data[p];
    const bool all = !all_regions.empty() && all_regions[i];
    masks[i] =
        (all ? CutRegions : CutRegion)(images[i], odds, options.smoothness, options.odds_limit / 2);
  });
  return masks;
}

void RequireCleanPlateFits(const std::vector<Image8>& images, const Image8& clean_plate) {
  for (const Image8& image : images)
    if (image.width != clean_plate.width || image.height != clean_plate.height)
      throw InputError("capture: the clean plate has another shape than the photographs (" +
                       std::to_string(clean_plate.width) + " x " +
                       std::to_string(clean_plate.height) + " against " +
                       std::to_string(image.width) + " x " + std::to_string(image.height) +
                       " at working size): photograph the empty set with the same camera settings");
}

constexpr double kGuideNoise = 5;  // 8 bit levels: differences of colour that are no edge
constexpr int kLargeRadius = 8;    // pixels, from which a fraction of the picture's size suffices

/// The mask at the picture's size, by the guided filter.
Image8 GuidedWhole(const Image8& image, const Image8& small_mask, int radius) {
  cv::Mat large, guided;
  cv::resize(MatOf(small_mask), large, {image.width, image.height}, 0, 0, cv::INTER_LINEAR);
  // The filter needs some thirty planes of floats. Two radii beyond the mask its result is zero for
  // any picture, so it is applied to the mask's surroundings only.
  const int margin = 4 * radius;
  cv::Rect box = cv::boundingRect(large);
  if (box.empty()) return ImageOf(large);
  box = cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) &
        cv::Rect({0, 0}, large.size());
  GuidedFilter(MatOf(image)(box).clone(), large(box).clone(), radius, kGuideNoise * kGuideNoise,
               &guided);
  cv::Mat mask = cv::Mat::zeros(large.size(), CV_8U);
  mask(box).setTo(255, guided > 127);
  return ImageOf(mask);
}

}  // namespace

std::vector<Image8> SegmentSet(const std::vector<Image8>& images, const Image8& clean_plate,
                               const std::vector<BoardOdds>& boards, const MaskOptions& options,
                               Progress* progress, const std::vector<char>& all_regions) {
  cv::setNumThreads(1);  // the loops over images already use all cores
  if (images.empty()) throw InputError("capture: no photographs to mask");
  std::vector<BoardOdds> known = boards;
  known.resize(images.size());
  if (!clean_plate.empty()) {
    RequireCleanPlateFits(images, clean_plate);
    ReportProgress(progress, 0, "masks from the clean plate");
    return SegmentByCleanPlate(images, clean_plate, known, options, all_regions);
  }
  // All rounds but the last work at half the size: they are only for learning.
  std::vector<Image8> small;
  for (const Image8& image : images)
    small.push_back(WorkingImage(image, std::max(image.width, image.height) / 2));
  Round coarse{small, {}, {}, {}, nullptr, {}};
  for (const Image8& image : small) {
    coarse.lab.push_back(LabOf(image));
    coarse.trimaps.push_back(FirstTrimap(image.width, image.height, options.border_share));
  }
  coarse.takes = FindTakes(small, options.border_share);
  const std::vector<BoardOdds> small_boards = Halved(known, small);
  for (int round = 0; round + 1 < options.rounds; ++round) {
    ReportProgress(progress, static_cast<double>(round) / options.rounds, "masks");
    for (std::size_t i = 0; i < small.size(); ++i)
      LeaveOutBoard(coarse.trimaps[i], small_boards[i]);
    const std::vector<Image8> masks =
        round < kColorRounds ? SegmentByColor(small, coarse.trimaps, small_boards, options)
                             : SegmentByClassifier(coarse, small_boards, options);
    for (std::size_t i = 0; i < masks.size(); ++i) coarse.trimaps[i] = TrimapOf(masks[i]);
  }
  ReportProgress(progress, static_cast<double>(options.rounds - 1) / options.rounds, "masks");
  Round fine{images, {}, {}, coarse.takes, nullptr, {}, all_regions};
  for (std::size_t i = 0; i < images.size(); ++i) {
    fine.lab.push_back(LabOf(images[i]));
    fine.trimaps.push_back(Enlarged(coarse.trimaps[i], images[i].width, images[i].height));
    LeaveOutBoard(fine.trimaps[i], known[i]);
  }
  return SegmentByClassifier(fine, known, options);
}

Image8 RefinedRegions(const Image8& image, const Image8& small_mask, const Backdrop* backdrop) {
  if (small_mask.width == image.width && small_mask.height == image.height) {
    Image8 matted = small_mask;
    if (backdrop) OpenMaskHoles(image, *backdrop, matted);
    MatteBoundary(image, matted);
    return matted;
  }
  // A radius of two pixels of the small mask.
  const int radius = std::max(2, 2 * image.width / std::max(1, small_mask.width));
  Image8 matted = radius < kLargeRadius ? GuidedWhole(image, small_mask, radius)
                                        : GuidedMask(image, small_mask, radius, kGuideNoise);
  if (backdrop) OpenMaskHoles(image, *backdrop, matted);
  MatteBoundary(image, matted);
  return matted;
}

Image8 RefinedMask(const Image8& image, const Image8& small_mask, const Backdrop* backdrop) {
  return BestRegion(RefinedRegions(image, small_mask, backdrop));
}

}  // namespace keypose::capture
