#include "capture/room/first_masks.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "capture/agreement/space_queries.h"
#include "capture/pictures/cv_image.h"
#include "capture/pictures/working_image.h"
#include "capture/segmentation/empty_set.h"
#include "capture/segmentation/region_cut.h"
#include "capture/segmentation/set_rounds.h"
#include "capture/segmentation/trimap.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::capture {
namespace {

// Of the network's 255, in the middles of its steps of 17.
constexpr int kSureFigure = 178, kSureRoom = 76, kLikely = 127;
constexpr double kNothing = 0.002;  // of the picture: a mask of less is none
constexpr double kNearlyAll = 0.9;  // a mask of more is none either
constexpr int kDenied = 2;          // told photographs that see past a place, which is then outside
constexpr int kFewestTold = 12;     // pixels of a region
constexpr int kToldPerDenial = 18;  // told photographs, for each of which one denial counts
constexpr double kSeen = 0.75;      // of the told photographs, which show the figure whole
constexpr float kToldOdds = 3;      // of what the network or a person said of a pixel
/// Log odds of the figure by the number of told photographs that see past it. A hull of few
/// photographs is much larger than the figure.
constexpr float kSpaceOdds[] = {0.7F, -0.7F, -4, -6};

std::uint8_t KindAt(const ToldView& view, std::size_t pixel) {
  return view.kinds.empty() ? std::uint8_t{kNotTold} : view.kinds.data[pixel];
}

Image8 KindsOf(const Image8& salience) {
  Image8 kinds(salience.width, salience.height, 1, kToldOpen);
  for (std::size_t p = 0; p < kinds.data.size(); ++p) {
    if (salience.data[p] > kSureFigure) kinds.data[p] = kToldFigure;
    if (salience.data[p] < kSureRoom) kinds.data[p] = kToldRoom;
  }
  return kinds;
}

/// From a mask, whose border is open.
Image8 KindsOfMask(const Image8& mask) {
  Image8 kinds = TrimapOf(mask);
  const auto told = [](std::uint8_t kind) {
    if (kind == kObject) return kToldFigure;
    return kind == kBackground ? kToldRoom : kToldOpen;
  };
  for (std::uint8_t& k : kinds.data) k = told(k);
  return kinds;
}

float OddsOfTold(int kind) {
  if (kind == kToldFigure) return kToldOdds;
  if (kind == kToldRoom) return -kToldOdds;
  return kind == kToldLikelyRoom ? -kToldOdds / 2 : 0;
}

Image8 LikelyOf(const Image8& salience) {
  Image8 mask(salience.width, salience.height, 1, 0);
  for (std::size_t p = 0; p < mask.data.size(); ++p)
    mask.data[p] = salience.data[p] > kLikely ? 255 : 0;
  return BestRegion(mask);
}

ToldView Tell(const Image8& rgb, const Image8& salience, const ViewStrokes& strokes) {
  if (!strokes.empty()) {
    Image8 mask = MaskOfStrokes(rgb, salience, strokes);
    if (mask.empty()) return {};
    Image8 kinds = KindsOfMask(mask);
    return {std::move(mask), std::move(kinds)};
  }
  if (salience.empty()) return {};
  ToldView told{LikelyOf(salience), KindsOf(salience)};
  for (std::size_t p = 0; p < told.mask.data.size(); ++p)
    if (told.kinds.data[p] == kToldFigure && told.mask.data[p] == 0) told.kinds.data[p] = kToldOpen;
  return told;
}

bool IsUsable(const Image8& mask) {
  if (mask.empty()) return false;
  const double share = MaskFraction(mask);
  return share > kNothing && share < kNearlyAll;
}

}  // namespace

std::vector<double> LeftByOthers(const std::vector<View>& views, const std::vector<Image8>& masks,
                                 const SpaceOptions& space) {
  std::vector<double> left(views.size(), 0);
  std::vector<Image8> contradictions;
  try {
    contradictions = ContradictionsByOthers(views, masks, space);
  } catch (const InputError&) {
    return left;
  }
  for (std::size_t v = 0; v < views.size(); ++v) {
    double all = 0, kept = 0;
    for (std::size_t p = 0; p < masks[v].data.size(); ++p) {
      if (masks[v].data[p] <= kLikely) continue;
      all += 1;
      kept += contradictions[v].data[p] < kDenied;
    }
    left[v] = all > 0 ? kept / all : 0;
  }
  return left;
}

namespace {

template <class T>
std::vector<T> Pick(const std::vector<T>& all, const std::vector<int>& which) {
  std::vector<T> some;
  for (const int i : which) some.push_back(all[static_cast<std::size_t>(i)]);
  return some;
}

/// The told views that fit each other: the one without which the others keep most is left out, as
/// long as some view keeps less than `same` of its mask.
std::vector<int> Fitting(std::vector<int> told, const std::vector<View>& views,
                         const std::vector<Image8>& masks, const SpaceOptions& space,
                         const FirstMasksOptions& options) {
  while (SizeOf(told) >= options.fewest) {
    const std::vector<double> left = LeftByOthers(Pick(views, told), Pick(masks, told), space);
    if (*std::min_element(left.begin(), left.end()) >= options.same) return told;
    if (SizeOf(told) == options.fewest) break;
    double most = -1;
    std::vector<int> better;
    for (std::size_t k = 0; k < told.size(); ++k) {
      std::vector<int> rest = told;
      rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(k));
      const std::vector<double> kept = LeftByOthers(Pick(views, rest), Pick(masks, rest), space);
      const double mean =
          std::accumulate(kept.begin(), kept.end(), 0.0) / static_cast<double>(kept.size());
      if (mean <= most) continue;
      most = mean;
      better = std::move(rest);
    }
    told = std::move(better);
  }
  return {};
}

/// The assumed labels of a view: what is told, and outside of the told photographs' common space
/// the room.
Image8 TrimapOfTold(const ToldView& told, const Image8& denied) {
  Image8 trimap(denied.width, denied.height, 1, kUnknown);
  for (std::size_t p = 0; p < trimap.data.size(); ++p) {
    const std::uint8_t kind = KindAt(told, p);
    if (kind == kToldFigure && denied.data[p] < kDenied) trimap.data[p] = kObject;
    if (kind == kToldRoom || denied.data[p] >= kDenied) trimap.data[p] = kBackground;
  }
  return trimap;
}

/// The regions of a mask in which the figure was told; the best where it was told in none.
Image8 RegionsTold(const Image8& mask, const Image8& kinds) {
  cv::Mat1i labels;
  const int count = cv::connectedComponents(MatOf(mask) > 127, labels, 8, CV_32S);
  std::vector<int> figure(static_cast<std::size_t>(count), 0);
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      figure[static_cast<std::size_t>(labels(y, x))] += *kinds.at(x, y) == kToldFigure;
  Image8 told(mask.width, mask.height, 1, 0);
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      if (const int label = labels(y, x);
          label > 0 && figure[static_cast<std::size_t>(label)] >= kFewestTold)
        *told.at(x, y) = 255;
  return MaskFraction(told) > 0 ? told : BestRegion(mask);
}

SpaceOptions SpaceOfTold(SpaceOptions space) {
  space.least_seen = kSeen;
  return space;
}

}  // namespace

std::vector<Image8> CarryToAll(const std::vector<Image8>& images, const std::vector<View>& views,
                               const ToldFigure& told, const std::vector<BoardOdds>& boards,
                               const MaskOptions& masking, const SpaceOptions& space) {
  std::vector<Image8> masks;
  std::vector<char> counts(images.size(), 0);
  for (const int i : told.fitting) counts[static_cast<std::size_t>(i)] = 1;
  for (std::size_t i = 0; i < images.size(); ++i)
    masks.push_back(counts[i] ? told.views[i].mask
                              : Image8(images[i].width, images[i].height, 1, 0));
  std::vector<Image8> denied = ContradictionsByOthers(views, masks, SpaceOfTold(space), counts);
  // Of many told photographs a few err.
  const int step = std::max(1, SizeOf(told.fitting) / kToldPerDenial);
  for (Image8& view : denied)
    for (std::uint8_t& d : view.data) d = static_cast<std::uint8_t>(d / step);
  const int spaces = SizeOf(kSpaceOdds);
  Round round{images, {}, {}, FindTakes(images, masking.border_share), nullptr, {}};
  std::vector<Image8> kinds = denied;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const ToldView none;
    const ToldView& view = counts[i] ? told.views[i] : none;
    round.lab.push_back(LabOf(images[i]));
    round.trimaps.push_back(TrimapOfTold(view, denied[i]));
    for (std::size_t p = 0; p < kinds[i].data.size(); ++p) {
      const int past = std::min<int>(denied[i].data[p], spaces - 1);
      kinds[i].data[p] = static_cast<std::uint8_t>(KindAt(view, p) * spaces + past);
    }
  }
  for (int kind = 0; kind < kToldKinds; ++kind)
    for (const float odds : kSpaceOdds) round.odds_told.push_back(odds + OddsOfTold(kind));
  round.told = &kinds;
  std::vector<BoardOdds> known = boards;
  known.resize(images.size());
  if (told.in_pieces) round.all_regions.assign(images.size(), 1);
  std::vector<Image8> carried = SegmentByClassifier(round, known, masking);
  if (told.in_pieces)
    for (std::size_t i = 0; i < carried.size(); ++i)
      if (counts[i]) carried[i] = RegionsTold(carried[i], told.views[i].kinds);
  return carried;
}

ToldFigure AskAboutFigure(const std::vector<Image8>& images, const std::vector<View>& views,
                          const Eigen::Vector3d& middle, const std::vector<int>& turns,
                          const std::vector<ViewStrokes>& strokes, const Salience& salience,
                          const SpaceOptions& space, const FirstMasksOptions& options,
                          Progress* progress) {
  ToldFigure told;
  told.views.resize(images.size());
  std::vector<int> marked;
  for (int i = 0; i < SizeOf(strokes); ++i)
    if (!strokes[static_cast<std::size_t>(i)].empty()) marked.push_back(i);
  const int ask = SizeOf(views) <= options.few ? SizeOf(views) : options.ask + SizeOf(marked);
  told.asked = salience ? ViewsToAsk(views, middle, ask, marked) : marked;
  // Marked ones first: where they show that the network errs, it is not asked about others.
  std::stable_partition(told.asked.begin(), told.asked.end(), [&](int i) {
    return std::find(marked.begin(), marked.end(), i) != marked.end();
  });
  bool& errs = told.network_errs;
  std::vector<Image8> masks(images.size());
  std::vector<int> usable;
  for (std::size_t k = 0; k < told.asked.size(); ++k) {
    if (errs && k >= marked.size()) {
      told.asked.resize(k);
      break;
    }
    ReportProgress(progress, static_cast<double>(k) / static_cast<double>(told.asked.size()),
                   "what is the figure");
    const auto i = static_cast<std::size_t>(told.asked[k]);
    const Image8 seen = salience ? AskUpright(salience, images[i], turns[i]) : Image8{};
    if (i < strokes.size()) errs = errs || TakesBothForOne(seen, strokes[i]);
    ToldView& view = told.views[i];
    view = Tell(images[i], seen, i < strokes.size() ? strokes[i] : ViewStrokes{});
    if (!IsUsable(view.mask)) continue;
    masks[i] = view.mask;
    usable.push_back(static_cast<int>(i));
  }
  std::sort(usable.begin(), usable.end());
  told.fitting = Fitting(usable, views, masks, SpaceOfTold(space), options);
  return told;
}

}  // namespace keypose::capture
