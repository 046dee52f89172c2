#include "capture/agreement/space_masks.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "capture/agreement/space_queries.h"
#include "capture/agreement/windows.h"
#include "capture/pictures/cv_image.h"
#include "capture/pictures/working_image.h"
#include "capture/segmentation/set_rounds.h"

namespace keypose::capture {
namespace {

/// Log odds of the figure for each number of denials, from its frequency inside and just outside of
/// the masks.
std::vector<float> OddsOfDenials(const std::vector<Image8>& masks,
                                 const std::vector<Image8>& denials,
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
        const std::uint8_t d = *denials[i].at(x, y);
        if (*masks[i].at(x, y) > 127)
          inside[d] += 1, all_inside += 1;
        else if (near.at<std::uint8_t>(y, x))
          outside[d] += 1, all_outside += 1;
      }
  }
  std::vector<float> odds(inside.size());
  for (std::size_t d = 0; d < odds.size(); ++d)
    odds[d] = static_cast<float>(std::log((inside[d] / std::max(all_inside, 1.0) + 1e-3) /
                                          (outside[d] / std::max(all_outside, 1.0) + 1e-3)));
  // More denials never increase the odds of the figure.
  for (std::size_t d = 1; d < odds.size(); ++d) odds[d] = std::min(odds[d], odds[d - 1]);
  return odds;
}

/// One round at one size: the weighted odds from the others' denials are added to the classifier's.
/// @param guided  one per view: with 0 the others' denials are not used
std::vector<Image8> SpaceRound(const std::vector<Image8>& images, const std::vector<Image8>& masks,
                               const std::vector<Image8>& denials, const std::vector<char>& inlier,
                               const std::vector<char>& guided,
                               const std::vector<BoardOdds>& boards, const MaskOptions& masking,
                               const SpaceOptions& options, double weight) {
  constexpr double kManyViews = 48;
  // A hull is larger than its figure, the more so the fewer the views. So the absence of denials
  // has less weight than denials.
  std::vector<float> leaning_of = OddsOfDenials(masks, denials, inlier, options.most_denials);
  const double sure = std::clamp(static_cast<double>(images.size()) / kManyViews, 0.5, 1.0);
  for (float& odds : leaning_of) odds *= static_cast<float>(odds < 0 ? weight : sure * weight);
  // Views without guidance get an additional kind of pixel with odds of zero.
  const auto untold = static_cast<std::uint8_t>(leaning_of.size());
  leaning_of.push_back(0);
  std::vector<Image8> told = denials;
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

}  // namespace

RefinedMasks RefineInSpace(const std::vector<Image8>& images, const std::vector<Image8>& masks,
                           const std::vector<View>& views, const std::vector<BoardOdds>& boards,
                           const MaskOptions& masking, const SpaceOptions& options,
                           Progress* progress) {
  cv::setNumThreads(1);
  std::vector<BoardOdds> known = boards;
  known.resize(images.size());
  // All rounds but the last work at half the size: they decide which parts belong to the figure.
  // The last one locates the outline.
  std::vector<Image8> small, small_masks;
  std::vector<View> small_views = views;
  for (std::size_t i = 0; i < images.size(); ++i) {
    small.push_back(WorkingImage(images[i], std::max(images[i].width, images[i].height) / 2));
    small_masks.push_back(ResizedMask(masks[i], small[i].width, small[i].height));
    small_views[i].camera =
        views[i].camera.Scaled(static_cast<double>(small[i].width) / images[i].width);
  }
  const std::vector<BoardOdds> small_boards = Halved(known, small);
  SpaceOptions coarse = options;
  coarse.resolution = std::max(16, options.resolution * 3 / 4);
  coarse.margin_px = 0.7 * options.margin_px;
  RefinedMasks refined;
  const auto denials_by = [&](const std::vector<char>& inlier) {
    const auto inliers =
        inlier.empty() ? views.size()
                       : static_cast<std::size_t>(std::count(inlier.begin(), inlier.end(), 1));
    return Denials{DenialsByOthers(small_views, small_masks, coarse, inlier),
                   DenialsToldApart(inliers, coarse)};
  };
  Denials denials = denials_by({});
  refined.agreement_before = AgreementInSpace(small_masks, denials.pictures);
  const auto judge = [&] {
    ViewConsensus consensus = JudgeOutlines(small_masks, denials, denials_by, options.consensus);
    const SpaceSurface surface = SurfaceOfSpace(small_views, small_masks, coarse, consensus.inlier);
    consensus.colors = FitsOfColors(small, small_masks, small_views, surface.points, surface.cell,
                                    consensus.inlier, options.colors);
    const std::vector<char> by_outline = consensus.inlier;
    JudgeColors(consensus.colors, options.colors, consensus.inlier);
    if (consensus.inlier != by_outline) denials = denials_by(consensus.inlier);
    const auto outliers =
        static_cast<double>(std::count(consensus.inlier.begin(), consensus.inlier.end(), 0));
    consensus.undecided |=
        outliers > options.consensus.most_doubtful * static_cast<double>(views.size());
    return consensus;
  };
  refined.consensus_before = judge();
  std::vector<char> inlier = refined.consensus_before.inlier;
  // The initial masks of the others are partly wrong, so their denials have less weight in the
  // first round.
  for (const double weight : {1.0, options.weight, options.weight}) {
    ReportProgress(progress, 0.15 * weight, "masks in space");
    small_masks = SpaceRound(small, small_masks, denials.pictures, inlier, inlier, small_boards,
                             masking, coarse, weight);
    denials = denials_by(inlier);
  }
  refined.agreement = AgreementInSpace(small_masks, denials.pictures);
  denials = denials_by({});
  refined.consensus = judge();
  if (const std::vector<std::size_t> again = OutliersByOutline(refined.consensus, options.colors);
      !again.empty()) {
    const std::vector<Image8> unguided = small_masks;
    const std::vector<Image8> with_guide = SpaceRound(
        small, small_masks, denials.pictures, refined.consensus.inlier,
        std::vector<char>(views.size(), 1), small_boards, masking, coarse, options.weight);
    for (const std::size_t i : again) small_masks[i] = with_guide[i];
    denials = denials_by({});
    refined.consensus = judge();
    for (const std::size_t i : again)
      if (!refined.consensus.inlier[i]) small_masks[i] = unguided[i];
  }
  inlier = refined.consensus.inlier;
  ReportProgress(progress, 0.6, "masks in space");
  std::vector<Image8> large;
  for (std::size_t i = 0; i < images.size(); ++i)
    large.push_back(ResizedMask(small_masks[i], images[i].width, images[i].height));
  std::vector<Image8> lab;
  for (const Image8& image : images) lab.push_back(LabOf(image));
  const std::vector<Take> takes = FindTakes(images, masking.border_share);
  const auto round = [&](const std::vector<Image8>& from) {
    refined.masks = SpaceRound(images, from, DenialsByOthers(views, from, options, inlier), inlier,
                               inlier, known, masking, options, options.weight);
    std::vector<Image8> trimaps;
    for (const Image8& mask : refined.masks) trimaps.push_back(TrimapOf(mask));
    return BackdropsOf(lab, trimaps, takes, masking.largest_misfit);
  };
  // of the figure; smaller openings do not change the other masks
  constexpr double kWorthARound = 3e-4;
  Backdrops backdrops = round(large);
  std::vector<Image8> open = refined.masks;
  if (OpenWindows(images, views, backdrops.of, options, inlier, open) > kWorthARound) {
    backdrops = round(open);
    OpenWindows(images, views, backdrops.of, options, inlier, refined.masks);
  }
  refined.backdrops = std::move(backdrops.of);
  if (backdrops.Confusing())
    for (Backdrop& backdrop : refined.backdrops) backdrop.empty = {};
  if (std::all_of(refined.backdrops.begin(), refined.backdrops.end(),
                  [](const Backdrop& b) { return b.empty.empty(); }))
    return refined;
  std::vector<Image8> thickness = ThicknessOfHull(views, refined.masks, options, inlier);
  for (std::size_t i = 0; i < images.size(); ++i)
    refined.backdrops[i].thickness = std::move(thickness[i]);
  return refined;
}

}  // namespace keypose::capture
