#include "capture/masking.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/ximgproc/edge_filter.hpp>
#include <string>

#include "capture/empty_set.h"
#include "capture/region_cut.h"
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

constexpr float kShadow = -1;                   // odds below which a pixel counts as shadow
constexpr int kColorRounds = 2;                 // a forest needs zones that are nearly right
constexpr std::size_t kSamplesPerImage = 2000;  // of each kind

/// Pixels of an image that zones give a kind, evenly spread.
PixelSamples SamplesOf(const std::vector<PixelFeatures>& features, const Image8& zones) {
  PixelSamples samples;
  for (const Zone zone : {kBackground, kObject}) {
    const auto count = static_cast<std::size_t>(std::count(zones.data.begin(), zones.data.end(), zone));
    // A stride that shares no factor with the width would do as well; a fractional one never falls into step with rows.
    const double stride = std::max(1.0, static_cast<double>(count) / kSamplesPerImage);
    double next = stride / 2;
    std::size_t seen = 0;
    for (std::size_t i = 0; i < features.size(); ++i) {
      if (zones.data[i] != zone || static_cast<double>(++seen) < next) continue;
      next += stride;
      samples.features.push_back(features[i]);
      samples.object.push_back(zone == kObject);
    }
  }
  return samples;
}

/// Everything one round knows of the set.
struct Round {
  const std::vector<Image8>& images;
  std::vector<Image8> lab;
  std::vector<Image8> zones;
  std::vector<Take> takes;

  const Take& TakeOf(std::size_t i) const {
    for (const Take& take : takes)
      if (i < take.end) return take;
    return takes.back();
  }
};

/// For each kind of pixel that may be shadow (entry 1 + kind), log odds that it is figure all the same. Shadow hangs on to a mask's rim;
/// what is the figure's own lies well inside as well.
std::vector<float> ShadowOdds(const Round& round, const std::vector<Image8>& kinds) {
  std::vector<double> inside(1 + kShadowKinds, 0), rim(inside);
  double all_inside = 0, all_rim = 0;
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    cv::Mat core;
    const int reach = 1 + 2 * (round.images[i].width / 24);
    cv::erode(View(round.zones[i]) == kObject, core, cv::getStructuringElement(cv::MORPH_ELLIPSE, {reach, reach}));
    const Image8 deep = FromMat(core);
    for (std::size_t p = 0; p < deep.data.size(); ++p) {
      if (round.zones[i].data[p] != kObject) continue;
      (deep.data[p] ? inside : rim)[kinds[i].data[p]] += 1;
      (deep.data[p] ? all_inside : all_rim) += 1;
    }
  }
  std::vector<float> odds(1 + kShadowKinds, 0);
  constexpr double kNothing = 2e-4;  // a share that tells nothing
  for (std::size_t k = 1; k < odds.size(); ++k)
    odds[k] =
        static_cast<float>(2 * std::log((inside[k] / std::max(all_inside, 1.0) + kNothing) / (rim[k] / std::max(all_rim, 1.0) + kNothing)));
  return odds;
}

/// Which photographs a forest that judges photograph i may not have learned from: a quarter of the set in its order, so that an error
/// that a few neighbours share cannot confirm itself.
std::size_t FoldOf(std::size_t i, std::size_t count, std::size_t folds) { return i * folds / count; }

std::vector<PixelForest> Learn(const std::vector<PixelSamples>& samples) {
  const std::size_t folds = samples.size() >= 8 ? 4 : 1;
  std::vector<PixelForest> forests;
  for (std::size_t fold = 0; fold < folds; ++fold) {
    std::vector<const PixelSamples*> others;
    for (std::size_t i = 0; i < samples.size(); ++i)
      if (folds == 1 || FoldOf(i, samples.size(), folds) != fold) others.push_back(&samples[i]);
    forests.emplace_back(others, ForestOptions{});
  }
  return forests;
}

/// One round over the set: learn the zones' colours, then segment each image by the set's odds and its own together.
std::vector<Image8> SegmentByColor(const std::vector<Image8>& images, const std::vector<Image8>& zones,
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
    masks[i] = CutRegion(images[i], known, options.smoothness, options.odds_limit / 2);
  });
  return masks;
}

/// One round over the set: learn from the zones, then segment each image by what the others taught.
std::vector<Image8> SegmentByForest(const Round& round, const std::vector<BoardOdds>& boards, const MaskOptions& options) {
  const std::size_t count = round.images.size();
  std::vector<Image8> masks(count), kinds(count), empties(count);
  std::vector<char> foretold(count);
  std::vector<PixelSamples> related(count), plain(count);
  const auto each = static_cast<std::int64_t>(count);
  ParallelFor(each, [&](std::int64_t k) {
    const auto i = static_cast<std::size_t>(k);
    empties[i] = EmptySet(round.lab, round.zones, round.TakeOf(i), i);
    foretold[i] = Misfit(round.lab[i], empties[i], round.zones[i]) < options.largest_misfit;
    kinds[i] = foretold[i] ? ShadowKinds(round.lab[i], empties[i]) : Image8(round.lab[i].width, round.lab[i].height, 1, 0);
  });
  const std::vector<float> shadow_odds = ShadowOdds(round, kinds);
  ParallelFor(each, [&](std::int64_t k) {
    const auto i = static_cast<std::size_t>(k);
    Image8 zones = round.zones[i];
    for (std::size_t p = 0; p < zones.data.size(); ++p)
      if (shadow_odds[kinds[i].data[p]] < kShadow && zones.data[p] == kObject) zones.data[p] = kNeither;
    plain[i] = SamplesOf(FeaturesOf(round.lab[i], empties[i]), zones);
    if (foretold[i]) related[i] = plain[i];
    plain[i].features = WithoutEmptySet(std::move(plain[i].features));
  });
  const std::vector<PixelForest> with_set = Learn(related), without_set = Learn(plain);
  ParallelFor(each, [&](std::int64_t k) {
    const auto i = static_cast<std::size_t>(k);
    const PixelForest& forest = (foretold[i] ? with_set : without_set)[FoldOf(i, count, with_set.size())];
    std::vector<PixelFeatures> features = FeaturesOf(round.lab[i], empties[i]);
    if (!foretold[i]) features = WithoutEmptySet(std::move(features));
    ImageF odds(round.images[i].width, round.images[i].height, 1);
    for (std::size_t p = 0; p < features.size(); ++p) {
      odds.data[p] = forest.Odds(features[p], static_cast<float>(options.odds_limit));
      const float shadow = shadow_odds[kinds[i].data[p]];
      if (shadow < kShadow) odds.data[p] = std::min(odds.data[p], std::max(shadow, -static_cast<float>(options.odds_limit)));
    }
    AddBoard(odds, boards[i], options.odds_limit);
    masks[i] = CutRegion(round.images[i], odds, options.smoothness, options.odds_limit / 2);
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
    masks[i] = CutRegion(images[i], odds, options.smoothness, options.odds_limit / 2);
  });
  return masks;
}

Image8 Enlarged(const Image8& zones, int width, int height) {
  cv::Mat large;
  cv::resize(View(zones), large, {width, height}, 0, 0, cv::INTER_NEAREST);
  return FromMat(large);
}

/// What the printed plate tells, for images of half the size.
std::vector<BoardOdds> Halved(const std::vector<BoardOdds>& boards, const std::vector<Image8>& small) {
  std::vector<BoardOdds> halved(boards.size());
  for (std::size_t i = 0; i < boards.size(); ++i) {
    if (boards[i].odds.empty()) continue;
    halved[i].on_board = Enlarged(boards[i].on_board, small[i].width, small[i].height);
    halved[i].odds = ImageF(small[i].width, small[i].height, 1);
    const cv::Mat odds(boards[i].odds.height, boards[i].odds.width, CV_32F, const_cast<float*>(boards[i].odds.data.data()));
    cv::Mat to(small[i].height, small[i].width, CV_32F, halved[i].odds.data.data());
    cv::resize(odds, to, to.size(), 0, 0, cv::INTER_AREA);
  }
  return halved;
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
  Round coarse{small, {}, {}, {}};
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
  Round fine{images, {}, {}, coarse.takes};
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
  cv::resize(View(image), small, size, 0, 0, cv::INTER_AREA);
  return FromMat(small);
}

Image8 RefinedMask(const Image8& image, const Image8& small_mask) {
  if (small_mask.width == image.width && small_mask.height == image.height) return small_mask;
  cv::Mat large, guided;
  cv::resize(View(small_mask), large, {image.width, image.height}, 0, 0, cv::INTER_LINEAR);
  const int radius = std::max(2, 2 * image.width / std::max(1, small_mask.width));
  cv::ximgproc::guidedFilter(View(image), large, guided, radius, 25.0);
  return BestRegion(FromMat(guided > 127));
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
