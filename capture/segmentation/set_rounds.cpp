#include "capture/segmentation/set_rounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "capture/pictures/cv_image.h"
#include "capture/segmentation/colour_odds.h"
#include "capture/segmentation/pixel_classifier.h"
#include "capture/segmentation/region_cut.h"
#include "core/numbers/parallel.h"
#include "core/values/tuned.h"

namespace keypose::capture {
namespace {

/// On the calibration board its print decides. Colours, which were learned elsewhere (ink looks
/// like dark noses), have little weight.
void AddBoard(ImageF& odds, const BoardOdds& board, double limit) {
  if (board.odds.empty()) return;
  for (std::size_t i = 0; i < odds.data.size(); ++i) {
    if (!board.on_board.data[i]) continue;
    const double lean = std::clamp(static_cast<double>(odds.data[i]), -1.5, 1.5);
    odds.data[i] = static_cast<float>(std::clamp(2.0 * board.odds.data[i] + lean, -limit, limit));
  }
}

// Tuned on the plush dog, the skull and the synthetic weak ring
// (docs/algorithms/masks.md); of kHole there is no
// record. Sensitivity: docs/results/sensitivity.md.
struct SetRoundTuning {
  // of the largest depth of a mask, from which a pixel is well inside
  KEYPOSE_TUNED(double, kDepth, 0.33);
  KEYPOSE_TUNED(double, kHole, 1);  // mean log odds against the figure from which a hole stays open
  // log odds; pixels with lower ones are shadow, or background seen past the figure
  KEYPOSE_TUNED(float, kShadow, -1);
  // of the limit of the log odds: other photographs' evidence in space has nearly as much weight
  KEYPOSE_TUNED(double, kSeenPast, 0.8);
  // Up to this share of the figure that looks like the empty set, such pixels are holes; from
  // EmptySetTuning::kManyAlike on the figure has such colours.
  KEYPOSE_TUNED(double, kFewAlike, 7e-4);
};

constexpr std::size_t kSamplesPerImage = 2000;  // of each kind

/// Pixels of an image with a label in its trimap, evenly spread.
PixelSamples SamplesOf(const std::vector<PixelFeatures>& features, const Image8& trimap) {
  PixelSamples samples;
  for (const TrimapLabel label : {kBackground, kObject}) {
    const auto count =
        static_cast<std::size_t>(std::count(trimap.data.begin(), trimap.data.end(), label));
    // A fractional stride is never in phase with the rows.
    const double stride = std::max(1.0, static_cast<double>(count) / kSamplesPerImage);
    double next = stride / 2;
    std::size_t seen = 0;
    for (std::size_t i = 0; i < features.size(); ++i) {
      if (trimap.data[i] != label || static_cast<double>(++seen) < next) continue;
      next += stride;
      samples.features.push_back(features[i]);
      samples.object.push_back(label == kObject);
    }
  }
  return samples;
}

/// For each kind of pixel that may be shadow (entry 1 + kind), log odds that it is figure. Shadow
/// occurs at a mask's border; the figure's own colours also occur well inside.
std::vector<float> ShadowOdds(const Round& round, const std::vector<Image8>& kinds) {
  std::vector<double> inside(1 + kShadowKinds, 0), rim(inside);
  double all_inside = 0, all_rim = 0;
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    // The image frame counts as outside: a figure that it cuts has no depth there.
    cv::Mat padded, depth;
    cv::copyMakeBorder(MatOf(round.trimaps[i]) == kObject, padded, 1, 1, 1, 1, cv::BORDER_CONSTANT,
                       0);
    cv::distanceTransform(padded, depth, cv::DIST_L2, 3);
    double deepest = 0;
    cv::minMaxLoc(depth, nullptr, &deepest);
    const Image8 deep =
        ImageOf(depth(cv::Rect(1, 1, round.trimaps[i].width, round.trimaps[i].height)) >
                SetRoundTuning::kDepth * deepest);
    for (std::size_t p = 0; p < deep.data.size(); ++p) {
      if (round.trimaps[i].data[p] != kObject) continue;
      (deep.data[p] ? inside : rim)[kinds[i].data[p]] += 1;
      (deep.data[p] ? all_inside : all_rim) += 1;
    }
  }
  std::vector<float> odds(1 + kShadowKinds, 0);
  constexpr double kNothing = 2e-4;  // a negligible share
  for (std::size_t k = 1; k < odds.size(); ++k)
    odds[k] = static_cast<float>(2 * std::log((inside[k] / std::max(all_inside, 1.0) + kNothing) /
                                              (rim[k] / std::max(all_rim, 1.0) + kNothing)));
  return odds;
}

/// Pixels that match the empty set as closely as the background does: seen past the figure, or clay
/// of the background's colour.
struct EmptySetMatch {
  /// for each image; empty if its empty set is unknown
  std::vector<std::vector<char>> pixels;
  float odds = 0;  ///< of the figure at such a pixel

  float At(std::size_t image, std::size_t pixel) const {
    return pixels[image].empty() || !pixels[image][pixel] ? 0 : odds;
  }
};

/// A classifier learned from masks with a filled hole classifies background as figure there, and
/// the hull of such masks is filled as well. The empty set, where other photographs of the take
/// show it, corrects that.
EmptySetMatch FindSeenPast(const Round& round, const std::vector<Image8>& empties,
                           const std::vector<char>& foretold, double limit) {
  EmptySetMatch past{std::vector<std::vector<char>>(round.lab.size()), 0};
  std::vector<double> figure(round.lab.size(), 0), like(figure);
  ParallelFor(std::ssize(round.lab), [&](std::int64_t k) {
    const auto i = static_cast<std::size_t>(k);
    if (!foretold[i]) return;
    const std::vector<std::uint8_t>&pixels = round.lab[i].data, &empty = empties[i].data,
          &trimap = round.trimaps[i].data;
    const std::array<int, 3> usual = UsualDifference(round.lab[i], empties[i], round.trimaps[i]);
    past.pixels[i].resize(trimap.size());
    for (std::size_t p = 0; p < trimap.size(); ++p) {
      bool near = true;
      for (std::size_t c = 0; c < 3; ++c)
        near = near && std::abs(pixels[3 * p + c] - empty[3 * p + c]) <= usual[c];
      past.pixels[i][p] = near;
      figure[i] += trimap[p] == kObject;
      like[i] += near && trimap[p] == kObject;
    }
  });
  const auto sum = [](const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0);
  };
  // Clay of the background's colours (bone in the dark in front of a black cloth, a white chin in
  // shadow in front of white paper) has the same appearance.
  const double share = (sum(like) + 1) / (sum(figure) + 1);
  const double chance =
      std::clamp(std::log(EmptySetTuning::kManyAlike / share) /
                     std::log(EmptySetTuning::kManyAlike / SetRoundTuning::kFewAlike),
                 0.0, 1.0);
  past.odds = static_cast<float>(chance * std::max(std::log(share), -limit));
  return past;
}

/// For each photograph its fold, whose classifier does not learn from it: a quarter of the set in
/// its order, so that a common error of neighbouring images does not confirm itself. Of each size
/// it has a quarter: another camera has other colours, which three quarters of its photographs
/// teach.
std::vector<std::size_t> FoldsOf(const std::vector<Image8>& images) {
  const std::size_t folds = images.size() >= 8 ? 4 : 1;
  std::map<std::pair<int, int>, std::size_t> count, seen;
  for (const Image8& image : images) ++count[{image.width, image.height}];
  std::vector<std::size_t> fold_of;
  for (const Image8& image : images) {
    const std::pair size{image.width, image.height};
    fold_of.push_back(seen[size]++ * folds / count[size]);
  }
  return fold_of;
}

std::vector<PixelClassifier> Learn(const std::vector<PixelSamples>& samples,
                                   const std::vector<std::size_t>& fold_of) {
  const std::size_t folds = *std::max_element(fold_of.begin(), fold_of.end()) + 1;
  std::vector<PixelClassifier> classifiers;
  for (std::size_t fold = 0; fold < folds; ++fold) {
    std::vector<const PixelSamples*> others;
    for (std::size_t i = 0; i < samples.size(); ++i)
      if (folds == 1 || fold_of[i] != fold) others.push_back(&samples[i]);
    classifiers.emplace_back(others, ClassifierOptions{});
  }
  return classifiers;
}

/// What is known of each photograph in a round: its empty set, the kinds of shadow on it, samples.
struct RoundPictures {
  explicit RoundPictures(std::size_t count)
      : kinds(count), empties(count), foretold(count), related(count), plain(count) {}
  std::vector<Image8> kinds, empties;
  std::vector<char> foretold;                ///< its empty set is known
  std::vector<PixelSamples> related, plain;  ///< with the empty set (where known), without it
};

RoundPictures LookAtEmptySets(const Round& round, const MaskOptions& options) {
  RoundPictures pictures(round.images.size());
  ParallelFor(std::ssize(round.images), [&](std::int64_t k) {
    const auto i = static_cast<std::size_t>(k);
    Image8& empty = pictures.empties[i];
    empty = EmptySet(round.lab, round.trimaps, TakeOf(round.takes, i), i);
    pictures.foretold[i] = Misfit(round.lab[i], empty, round.trimaps[i]) < options.largest_misfit;
    pictures.kinds[i] = pictures.foretold[i]
                            ? ShadowKinds(round.lab[i], empty)
                            : Image8(round.lab[i].width, round.lab[i].height, 1, 0);
  });
  return pictures;
}

/// Samples what each photograph shows, without what may be shadow or the set seen past the figure.
void TakeSamples(const Round& round, const std::vector<float>& shadow_odds,
                 const EmptySetMatch& past, RoundPictures& pictures) {
  ParallelFor(std::ssize(round.images), [&](std::int64_t k) {
    const auto i = static_cast<std::size_t>(k);
    Image8 trimap = round.trimaps[i];
    for (std::size_t p = 0; p < trimap.data.size(); ++p)
      if (trimap.data[p] == kObject &&
          (shadow_odds[pictures.kinds[i].data[p]] < SetRoundTuning::kShadow ||
           past.At(i, p) < SetRoundTuning::kShadow))
        trimap.data[p] = kUnknown;
    PixelSamples& plain = pictures.plain[i];
    plain = SamplesOf(capture::FeaturesOf(round.lab[i], pictures.empties[i]), trimap);
    if (pictures.foretold[i]) pictures.related[i] = plain;
    plain.features = WithoutEmptySet(std::move(plain.features));
  });
}

}  // namespace

Image8 Enlarged(const Image8& image, int width, int height) {
  cv::Mat large;
  cv::resize(MatOf(image), large, {width, height}, 0, 0, cv::INTER_NEAREST);
  return ImageOf(large);
}

std::vector<BoardOdds> Halved(const std::vector<BoardOdds>& boards,
                              const std::vector<Image8>& small) {
  std::vector<BoardOdds> halved(boards.size());
  for (std::size_t i = 0; i < boards.size(); ++i) {
    if (boards[i].odds.empty()) continue;
    halved[i].on_board = Enlarged(boards[i].on_board, small[i].width, small[i].height);
    halved[i].odds = ImageF(small[i].width, small[i].height, 1);
    const cv::Mat odds(boards[i].odds.height, boards[i].odds.width, CV_32F,
                       const_cast<float*>(boards[i].odds.data.data()));
    cv::Mat to(small[i].height, small[i].width, CV_32F, halved[i].odds.data.data());
    cv::resize(odds, to, to.size(), 0, 0, cv::INTER_AREA);
  }
  return halved;
}

std::vector<Image8> SegmentByColor(const std::vector<Image8>& images,
                                   const std::vector<Image8>& trimaps,
                                   const std::vector<BoardOdds>& boards,
                                   const MaskOptions& options) {
  ColorOdds pooled;
  for (std::size_t i = 0; i < images.size(); ++i) pooled.Add(images[i], trimaps[i]);
  std::vector<Image8> masks(images.size());
  const float share = 1.0F / static_cast<float>(images.size());
  ParallelFor(std::ssize(images), [&](std::int64_t k) {
    const auto i = static_cast<std::size_t>(k);
    ColorOdds odds;
    odds.Add(images[i], trimaps[i]);
    odds.Add(pooled, share);  // the photograph has the same weight as the set
    odds.Finish();
    ImageF known = odds.Of(images[i], options.odds_limit);
    AddBoard(known, boards[i], options.odds_limit);
    masks[i] = CutRegion(images[i], known, options.smoothness, SetRoundTuning::kHole);
  });
  return masks;
}

std::vector<Image8> SegmentByClassifier(const Round& round, const std::vector<BoardOdds>& boards,
                                        const MaskOptions& options) {
  const std::size_t count = round.images.size();
  RoundPictures pictures = LookAtEmptySets(round, options);
  const std::vector<float> shadow_odds = ShadowOdds(round, pictures.kinds);
  const EmptySetMatch past = FindSeenPast(round, pictures.empties, pictures.foretold,
                                          SetRoundTuning::kSeenPast * options.odds_limit);
  TakeSamples(round, shadow_odds, past, pictures);
  const std::vector<std::size_t> fold_of = FoldsOf(round.images);
  const std::vector<PixelClassifier> with_set = Learn(pictures.related, fold_of),
                                     without_set = Learn(pictures.plain, fold_of);
  std::vector<Image8> masks(count);
  ParallelFor(std::ssize(round.images), [&](std::int64_t k) {
    const auto i = static_cast<std::size_t>(k);
    const bool foretold = pictures.foretold[i];
    const PixelClassifier& classifier = (foretold ? with_set : without_set)[fold_of[i]];
    std::vector<PixelFeatures> features = FeaturesOf(round.lab[i], pictures.empties[i]);
    if (!foretold) features = WithoutEmptySet(std::move(features));
    ImageF odds(round.images[i].width, round.images[i].height, 1);
    for (std::size_t p = 0; p < features.size(); ++p) {
      odds.data[p] = classifier.Odds(features[p], static_cast<float>(options.odds_limit));
      const float shadow = std::min(shadow_odds[pictures.kinds[i].data[p]], past.At(i, p));
      if (shadow < SetRoundTuning::kShadow)
        odds.data[p] =
            std::min(odds.data[p], std::max(shadow, -static_cast<float>(options.odds_limit)));
    }
    for (std::size_t p = 0; round.told && p < features.size(); ++p)
      odds.data[p] += round.odds_told[(*round.told)[i].data[p]];
    AddBoard(odds, boards[i], options.odds_limit);
    const bool all = !round.all_regions.empty() && round.all_regions[i];
    masks[i] = (all ? CutRegions : CutRegion)(round.images[i], odds, options.smoothness,
                                              SetRoundTuning::kHole);
  });
  return masks;
}

}  // namespace keypose::capture
