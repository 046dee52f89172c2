#include "capture/agreement/space_masks.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "capture/agreement/mask_windows.h"
#include "capture/agreement/space_queries.h"
#include "capture/pictures/cv_image.h"
#include "capture/pictures/working_image.h"
#include "capture/segmentation/set_rounds.h"
#include "core/values/tuned.h"

namespace keypose::capture {
namespace {

/// Tuned on the plush dog, the skull and synthetic sets of 16 to 36 views
/// (docs/algorithms/masks.md); no record of single values. Sensitivity:
/// docs/results/sensitivity.md.
struct SpaceMaskTuning {
  /// views from which odds for the figure count as much as odds against it, and the least share to
  /// which they count with fewer
  KEYPOSE_TUNED(double, kManyViews, 48);
  KEYPOSE_TUNED(double, kFewViews, 0.5);
  /// share of the pixels that is added to each frequency, so that all odds are finite
  KEYPOSE_TUNED(double, kRare, 1e-3);
  KEYPOSE_TUNED(double, kCoarseMargin, 0.7);  ///< at half the size, of the margin in pixels
  /// of the figure; smaller openings do not change the other masks
  KEYPOSE_TUNED(double, kWorthARound, 3e-4);
};

/// Log odds of the figure for each number of contradictions, from its frequency inside and just
/// outside of the masks.
std::vector<float> OddsOfContradictions(const std::vector<Image8>& masks,
                                        const std::vector<Image8>& contradictions,
                                        const std::vector<char>& inlier, int most) {
  std::vector<double> inside(static_cast<std::size_t>(most) + 1, 0), outside(inside);
  double all_inside = 0, all_outside = 0;
  for (std::size_t i = 0; i < masks.size(); ++i) {
    if (!inlier[i]) continue;
    cv::Mat near;
    const int reach = 1 + 2 * (masks[i].width / 24);
    cv::dilate(MatOf(masks[i]), near, cv::getStructuringElement(cv::MORPH_ELLIPSE, {reach, reach}));
    for (int y = 0; y < near.rows; ++y)
      for (int x = 0; x < near.cols; ++x) {
        const std::uint8_t d = *contradictions[i].at(x, y);
        if (*masks[i].at(x, y) > 127) {
          inside[d] += 1;
          all_inside += 1;
        } else if (near.at<std::uint8_t>(y, x)) {
          outside[d] += 1;
          all_outside += 1;
        }
      }
  }
  std::vector<float> odds(inside.size());
  for (std::size_t d = 0; d < odds.size(); ++d)
    odds[d] = static_cast<float>(
        std::log((inside[d] / std::max(all_inside, 1.0) + SpaceMaskTuning::kRare) /
                 (outside[d] / std::max(all_outside, 1.0) + SpaceMaskTuning::kRare)));
  // More contradictions never increase the odds of the figure.
  for (std::size_t d = 1; d < odds.size(); ++d) odds[d] = std::min(odds[d], odds[d - 1]);
  return odds;
}

/// One round at one size: the weighted odds from the others' contradictions are added to the
/// classifier's.
/// @param guided  one per view: with 0 the others' contradictions are not used
std::vector<Image8> SpaceRound(const std::vector<Image8>& images, const std::vector<Image8>& masks,
                               const std::vector<Image8>& contradictions,
                               const std::vector<char>& inlier, const std::vector<char>& guided,
                               const std::vector<BoardOdds>& boards, const MaskOptions& masking,
                               const SpaceOptions& options, double weight) {
  // A hull is larger than its figure, the more so the fewer the views. So the absence of
  // contradictions has less weight than contradictions.
  std::vector<float> leaning_of =
      OddsOfContradictions(masks, contradictions, inlier, options.most_contradictions);
  const double sure = std::clamp(static_cast<double>(images.size()) / SpaceMaskTuning::kManyViews,
                                 SpaceMaskTuning::kFewViews, 1.0);
  for (float& odds : leaning_of) odds *= static_cast<float>(odds < 0 ? weight : sure * weight);
  // Views without guidance get an additional kind of pixel with odds of zero.
  const auto untold = static_cast<std::uint8_t>(leaning_of.size());
  leaning_of.push_back(0);
  std::vector<Image8> told = contradictions;
  for (std::size_t i = 0; i < told.size(); ++i)
    if (!guided[i]) std::fill(told[i].data.begin(), told[i].data.end(), untold);
  Round round{
      images, {}, {}, FindTakes(images, masking.border_share), &told, std::move(leaning_of)};
  for (std::size_t i = 0; i < images.size(); ++i) {
    round.lab.push_back(LabOf(images[i]));
    round.trimaps.push_back(TrimapOf(masks[i]));
  }
  return SegmentByClassifier(round, boards, masking);
}

/// Views that are outliers in outline, but not in colour.
std::vector<std::size_t> OutliersByOutline(const ViewConsensus& consensus,
                                           const ColorOptions& options) {
  std::vector<std::size_t> outliers;
  for (std::size_t i = 0; i < consensus.inlier.size(); ++i)
    if (!consensus.inlier[i] && consensus.colors[i].contrary <= options.most_contrary)
      outliers.push_back(i);
  return outliers;
}

Image8 Binary(Image8 mask) {
  for (std::uint8_t& m : mask.data) m = m > 127 ? 255 : 0;
  return mask;
}

Image8 ResizedMask(const Image8& mask, int width, int height) {
  Image8 to(width, height, 1);
  cv::Mat view = MatOf(to);
  cv::resize(MatOf(mask), view, view.size(), 0, 0,
             mask.width > width ? cv::INTER_AREA : cv::INTER_LINEAR);
  return Binary(std::move(to));
}

/// The set at half the size, where it is decided which parts belong to the figure.
class CoarseMasks {
 public:
  CoarseMasks(const std::vector<Image8>& images, const std::vector<Image8>& masks,
              const std::vector<View>& views, const std::vector<BoardOdds>& boards,
              const MaskOptions& masking, const SpaceOptions& options);
  /// Fills the agreement and the consensus of `refined`.
  void Run(RefinedMasks& refined, Progress* progress);
  const std::vector<Image8>& masks() const { return masks_; }

 private:
  Contradictions ContradictionsBy(const std::vector<char>& inlier) const;
  /// Which views are consistent, by outline and by colour; contradictions_ are those of the inliers
  /// then.
  ViewConsensus Judge();
  std::vector<Image8> Segmented(const std::vector<char>& inlier, const std::vector<char>& guided,
                                double weight) const;
  /// Segments views that are outliers by outline alone once more, with the others' contradictions.
  void Reconsider(ViewConsensus& consensus);

  const MaskOptions& masking_;
  const SpaceOptions& options_;
  SpaceOptions coarse_;
  std::vector<Image8> images_, masks_;
  std::vector<View> views_;
  std::vector<BoardOdds> boards_;
  Contradictions contradictions_;
};

CoarseMasks::CoarseMasks(const std::vector<Image8>& images, const std::vector<Image8>& masks,
                         const std::vector<View>& views, const std::vector<BoardOdds>& boards,
                         const MaskOptions& masking, const SpaceOptions& options)
    : masking_(masking), options_(options), coarse_(options), views_(views) {
  for (std::size_t i = 0; i < images.size(); ++i) {
    images_.push_back(WorkingImage(images[i], std::max(images[i].width, images[i].height) / 2));
    masks_.push_back(ResizedMask(masks[i], images_[i].width, images_[i].height));
    views_[i].camera =
        views[i].camera.Scaled(static_cast<double>(images_[i].width) / images[i].width);
  }
  boards_ = Halved(boards, images_);
  coarse_.resolution = std::max(16, options.resolution * 3 / 4);
  coarse_.margin_px = SpaceMaskTuning::kCoarseMargin * options.margin_px;
}

Contradictions CoarseMasks::ContradictionsBy(const std::vector<char>& inlier) const {
  const auto inliers = inlier.empty()
                           ? views_.size()
                           : static_cast<std::size_t>(std::count(inlier.begin(), inlier.end(), 1));
  return {ContradictionsByOthers(views_, masks_, coarse_, inlier),
          MostContradictionsCounted(inliers, coarse_)};
}

ViewConsensus CoarseMasks::Judge() {
  const auto contradictions_by = [&](const std::vector<char>& inlier) {
    return ContradictionsBy(inlier);
  };
  ViewConsensus consensus =
      CheckOutlines(masks_, contradictions_, contradictions_by, options_.consensus);
  const SpaceSurface surface = SurfaceOfSpace(views_, masks_, coarse_, consensus.inlier);
  consensus.colors = FitsOfColors(images_, masks_, views_, surface.points, surface.cell,
                                  consensus.inlier, options_.colors);
  const std::vector<char> by_outline = consensus.inlier;
  CheckColors(consensus.colors, options_.colors, consensus.inlier);
  if (consensus.inlier != by_outline) contradictions_ = ContradictionsBy(consensus.inlier);
  const auto outliers =
      static_cast<double>(std::count(consensus.inlier.begin(), consensus.inlier.end(), 0));
  consensus.undecided |=
      outliers > options_.consensus.most_doubtful * static_cast<double>(views_.size());
  return consensus;
}

std::vector<Image8> CoarseMasks::Segmented(const std::vector<char>& inlier,
                                           const std::vector<char>& guided, double weight) const {
  return SpaceRound(images_, masks_, contradictions_.pictures, inlier, guided, boards_, masking_,
                    coarse_, weight);
}

void CoarseMasks::Reconsider(ViewConsensus& consensus) {
  if (options_.segmented) return;
  const std::vector<std::size_t> again = OutliersByOutline(consensus, options_.colors);
  if (again.empty()) return;
  const std::vector<Image8> unguided = masks_;
  const std::vector<Image8> guided =
      Segmented(consensus.inlier, std::vector<char>(views_.size(), 1), options_.weight);
  for (const std::size_t i : again) masks_[i] = guided[i];
  contradictions_ = ContradictionsBy({});
  consensus = Judge();
  for (const std::size_t i : again)
    if (!consensus.inlier[i]) masks_[i] = unguided[i];
}

void CoarseMasks::Run(RefinedMasks& refined, Progress* progress) {
  contradictions_ = ContradictionsBy({});
  refined.agreement_before = AgreementInSpace(masks_, contradictions_.pictures);
  refined.consensus_before = Judge();
  const std::vector<char>& inlier = refined.consensus_before.inlier;
  // The initial masks of the others are partly wrong, so their contradictions have less weight in
  // the first round.
  const std::vector<double> weights = options_.segmented
                                          ? std::vector<double>{}
                                          : std::vector{1.0, options_.weight, options_.weight};
  for (const double weight : weights) {
    ReportProgress(progress, 0.15 * weight, "masks in space");
    masks_ = Segmented(inlier, inlier, weight);
    contradictions_ = ContradictionsBy(inlier);
  }
  refined.agreement = AgreementInSpace(masks_, contradictions_.pictures);
  contradictions_ = ContradictionsBy({});
  refined.consensus = Judge();
  Reconsider(refined.consensus);
}

/// The set at its own size, where the outline is located and windows are opened.
class FineMasks {
 public:
  FineMasks(const std::vector<Image8>& images, const std::vector<View>& views,
            const std::vector<BoardOdds>& boards, const std::vector<char>& inlier,
            const MaskOptions& masking, const SpaceOptions& options)
      : images_(images),
        views_(views),
        boards_(boards),
        inlier_(inlier),
        masking_(masking),
        options_(options),
        takes_(FindTakes(images, masking.border_share)) {
    for (const Image8& image : images) lab_.push_back(LabOf(image));
  }
  /// Fills the masks and backdrops of `refined`. @param from  coarse masks at the images' size
  void Run(const std::vector<Image8>& from, RefinedMasks& refined) const;

 private:
  std::vector<Image8> Corrected(std::vector<Image8> masks) const;
  std::vector<Image8> Segmented(const std::vector<Image8>& from) const {
    return SpaceRound(images_, from, ContradictionsByOthers(views_, from, options_, inlier_),
                      inlier_, inlier_, boards_, masking_, options_, options_.weight);
  }
  Backdrops BackdropsBy(const std::vector<Image8>& masks) const {
    std::vector<Image8> trimaps;
    for (const Image8& mask : masks) trimaps.push_back(TrimapOf(mask));
    return BackdropsOf(lab_, trimaps, takes_, masking_.largest_misfit);
  }

  const std::vector<Image8>& images_;
  const std::vector<View>& views_;
  const std::vector<BoardOdds>& boards_;
  const std::vector<char>& inlier_;
  const MaskOptions& masking_;
  const SpaceOptions& options_;
  std::vector<Take> takes_;
  std::vector<Image8> lab_;
};

/// The masks without what most of the others that count see past.
std::vector<Image8> FineMasks::Corrected(std::vector<Image8> masks) const {
  const std::vector<Image8> contradictions =
      ContradictionsByOthers(views_, masks, options_, inlier_);
  const int most = MostContradictionsCounted(
      static_cast<std::size_t>(std::count(inlier_.begin(), inlier_.end(), 1)), options_);
  for (std::size_t i = 0; i < masks.size(); ++i) {
    if (!inlier_[i]) continue;
    for (std::size_t p = 0; p < masks[i].data.size(); ++p)
      if (contradictions[i].data[p] >= most) masks[i].data[p] = 0;
  }
  return masks;
}

void FineMasks::Run(const std::vector<Image8>& from, RefinedMasks& refined) const {
  refined.masks = options_.segmented ? Corrected(from) : Segmented(from);
  Backdrops backdrops = BackdropsBy(refined.masks);
  std::vector<Image8> open = refined.masks;
  if (OpenWindows(images_, views_, backdrops.of, options_, inlier_, open) >
      SpaceMaskTuning::kWorthARound) {
    refined.masks = options_.segmented ? open : Segmented(open);
    backdrops = BackdropsBy(refined.masks);
    OpenWindows(images_, views_, backdrops.of, options_, inlier_, refined.masks);
  }
  refined.backdrops = std::move(backdrops.of);
  if (backdrops.Confusing())
    for (Backdrop& backdrop : refined.backdrops) backdrop.empty = {};
  if (std::all_of(refined.backdrops.begin(), refined.backdrops.end(),
                  [](const Backdrop& b) { return b.empty.empty(); }))
    return;
  std::vector<Image8> thickness = ThicknessOfHull(views_, refined.masks, options_, inlier_);
  for (std::size_t i = 0; i < images_.size(); ++i)
    refined.backdrops[i].thickness = std::move(thickness[i]);
}

}  // namespace

RefinedMasks RefineInSpace(const std::vector<Image8>& images, const std::vector<Image8>& masks,
                           const std::vector<View>& views, const std::vector<BoardOdds>& boards,
                           const MaskOptions& masking, const SpaceOptions& options,
                           Progress* progress) {
  cv::setNumThreads(1);
  std::vector<BoardOdds> known = boards;
  known.resize(images.size());
  RefinedMasks refined;
  CoarseMasks coarse(images, masks, views, known, masking, options);
  coarse.Run(refined, progress);
  ReportProgress(progress, 0.6, "masks in space");
  std::vector<Image8> large;
  for (std::size_t i = 0; i < images.size(); ++i)
    large.push_back(options.segmented
                        ? masks[i]
                        : ResizedMask(coarse.masks()[i], images[i].width, images[i].height));
  FineMasks(images, views, known, refined.consensus.inlier, masking, options).Run(large, refined);
  return refined;
}

}  // namespace keypose::capture
