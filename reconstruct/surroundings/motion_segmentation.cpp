#include "reconstruct/surroundings/motion_segmentation.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <utility>

#include "core/numbers/kd_tree.h"
#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "reconstruct/numerics/epipolar.h"

namespace keypose::reconstruct {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Match = std::pair<std::uint32_t, std::uint32_t>;

/// Up to this many times the limit of what stays in place, as many matches are the figure's own
/// near the table's axis.
constexpr double kHardly = 3;
constexpr int kCell_px = 8;  // of regions

MotionVotes NoVotes(const std::vector<Features>& features) {
  MotionVotes votes;
  for (const Features& f : features) votes.emplace_back(static_cast<std::size_t>(f.count()), 0);
  return votes;
}

Vector2d PlaceOf(const Features& features, std::uint32_t f) {
  return features.positions.row(f).transpose().cast<double>();
}

double InPlace_px(int longer_side_px, const MotionSegmentationOptions& options) {
  return std::max(1.0, options.in_place * longer_side_px);
}

/// What each match of a pair says: 1, -1 or 0.
using Verdicts = std::vector<signed char>;

void Add(const PairMatches& pair, const Verdicts& verdicts, MotionVotes& votes) {
  for (std::size_t m = 0; m < verdicts.size(); ++m) {
    votes[pair.first][pair.features[m].first] += verdicts[m];
    votes[pair.second][pair.features[m].second] += verdicts[m];
  }
}

/// Empty where the camera was not fixed, or where nothing turned before it: then the figure stays
/// in place as well.
Verdicts BeforeTripod(const Features& first, const Features& second, const PairMatches& pair,
                      double limit_px, const MotionSegmentationOptions& options) {
  Verdicts verdicts;
  int still = 0, hardly = 0, moved = 0;
  for (const auto& [i, j] : pair.features) {
    const double by = (PlaceOf(first, i) - PlaceOf(second, j)).norm();
    const bool stays = by<limit_px, moves = by> options.nearly_in_place * limit_px;
    still += stays;
    moved += moves;
    hardly += !stays && by < kHardly * limit_px;
    verdicts.push_back(static_cast<signed char>(moves - stays));
  }
  if (still < options.fewest || still <= hardly || moved < options.fewest) verdicts.clear();
  return verdicts;
}

Verdicts AgainstCameras(const View& a, const View& b, const Features& first, const Features& second,
                        const PairMatches& pair, const MotionSegmentationOptions& options) {
  const Eigen::Matrix3d essential =
      EssentialOf(a.camera_from_world.rotation.toRotationMatrix(), a.camera_from_world.translation,
                  b.camera_from_world.rotation.toRotationMatrix(), b.camera_from_world.translation);
  const double fits = std::pow(options.fits_px / a.camera.fx, 2),
               misses = std::pow(options.misses_px / a.camera.fx, 2);
  Verdicts verdicts;
  for (const auto& [i, j] : pair.features) {
    const double off = SquaredSampson(essential, a.camera.Unproject(PlaceOf(first, i)),
                                      b.camera.Unproject(PlaceOf(second, j)));
    verdicts.push_back(static_cast<signed char>((off > misses) - (off < fits)));
  }
  return verdicts;
}

/// Features of an image that have votes.
struct Voters {
  PointsX3 places;  // z = 0
  std::vector<signed char> side;
};

Voters VotersOf(const Features& features, const std::vector<int>& votes) {
  Voters voters;
  for (const int vote : votes)
    if (vote != 0) voters.side.push_back(vote > 0 ? 1 : -1);
  voters.places.setZero(std::ssize(voters.side), 3);
  Eigen::Index at = 0;
  for (std::size_t f = 0; f < votes.size(); ++f)
    if (votes[f] != 0)
      voters.places.row(at++).head<2>() =
          PlaceOf(features, static_cast<std::uint32_t>(f)).transpose();
  return voters;
}

Image8 RegionOf(const Voters& voters, const Camera& lens, int neighbours) {
  if (SizeOf(voters.side) < 4 * neighbours) return {};
  const KdTree tree(voters.places);
  Image8 region((lens.width + kCell_px - 1) / kCell_px, (lens.height + kCell_px - 1) / kCell_px, 1);
  for (int y = 0; y < region.height; ++y)
    for (int x = 0; x < region.width; ++x) {
      int balance = 0;
      for (const auto& near :
           tree.Nearest(Vector3d((x + 0.5) * kCell_px, (y + 0.5) * kCell_px, 0), neighbours))
        balance += voters.side[near.index];
      *region.at(x, y) = balance > 0 ? 255 : 0;
    }
  return region;
}

/// All pairs of images that the given pairs connect: photographs from one tripod. Where the figure
/// turned far, a pair alone may not tell. Sorted.
std::vector<ImagePair> AllPairsOfGroups(int images, const std::vector<ImagePair>& pairs) {
  std::vector<int> group(static_cast<std::size_t>(images));
  std::iota(group.begin(), group.end(), 0);
  for (const auto& [i, j] : pairs) {
    const auto [least, other] = std::minmax({group[i], group[j]});
    std::replace(group.begin(), group.end(), other, least);
  }
  std::vector<ImagePair> all;
  for (int i = 0; i < images; ++i)
    for (int j = i + 1; j < images; ++j)
      if (group[i] == group[j]) all.emplace_back(i, j);
  return all;
}

}  // namespace

MotionVotes TurnsBeforeTripod(const std::vector<Features>& features,
                              const std::vector<PairMatches>& matches, int longer_side_px,
                              const MotionSegmentationOptions& options,
                              std::vector<ImagePair>* pairs) {
  const double limit_px = InPlace_px(longer_side_px, options);
  std::vector<Verdicts> verdicts(matches.size());
  ParallelFor(std::ssize(matches), [&](std::int64_t k) {
    const PairMatches& pair = matches[k];
    verdicts[k] =
        BeforeTripod(features[pair.first], features[pair.second], pair, limit_px, options);
  });
  MotionVotes votes = NoVotes(features);
  pairs->clear();
  for (std::size_t k = 0; k < matches.size(); ++k) {
    if (!verdicts[k].empty()) pairs->emplace_back(matches[k].first, matches[k].second);
    Add(matches[k], verdicts[k], votes);
  }
  *pairs = AllPairsOfGroups(SizeOf(features), *pairs);
  return votes;
}

int LeaveOutNearlyInPlace(const Features& first, const Features& second, int longer_side_px,
                          const MotionSegmentationOptions& options, PairMatches& pair) {
  const double limit_px = options.nearly_in_place * InPlace_px(longer_side_px, options);
  return static_cast<int>(std::erase_if(pair.features, [&](const Match& match) {
    return (PlaceOf(first, match.first) - PlaceOf(second, match.second)).norm() < limit_px;
  }));
}

MotionVotes MovesOtherwise(const std::vector<Features>& features,
                           const std::vector<PairMatches>& matches, const Scene& scene,
                           const std::vector<int>& view_of_image,
                           const MotionSegmentationOptions& options, Progress* progress) {
  std::vector<Verdicts> verdicts(matches.size());
  ParallelFor(std::ssize(matches), [&](std::int64_t k) {
    if (progress && progress->cancelled()) throw Cancelled();
    const PairMatches& pair = matches[k];
    const int a = view_of_image[pair.first], b = view_of_image[pair.second];
    // A few matches are mostly wrong ones.
    if (a < 0 || b < 0 || SizeOf(pair.features) < options.fewest) return;
    verdicts[k] = AgainstCameras(scene.views[a], scene.views[b], features[pair.first],
                                 features[pair.second], pair, options);
  });
  MotionVotes votes = NoVotes(features);
  for (std::size_t k = 0; k < matches.size(); ++k) Add(matches[k], verdicts[k], votes);
  return votes;
}

std::vector<Image8> MotionRegions(const std::vector<Features>& features, const MotionVotes& votes,
                                  const std::vector<Camera>& lens,
                                  const MotionSegmentationOptions& options) {
  std::vector<Image8> regions(features.size());
  ParallelFor(std::ssize(features), [&](std::int64_t i) {
    regions[i] = RegionOf(VotersOf(features[i], votes[i]), lens[i], options.neighbours);
  });
  return regions;
}

std::vector<int> CountInRegions(const std::vector<Features>& features, const MotionVotes& votes,
                                const std::vector<Camera>& lens,
                                const std::vector<Image8>& regions) {
  std::vector<int> counts(features.size(), 0);
  for (std::size_t i = 0; i < features.size(); ++i) {
    const Image8& region = regions[i];
    if (region.empty()) continue;
    for (std::size_t f = 0; f < votes[i].size(); ++f) {
      if (votes[i][f] <= 0) continue;
      const Vector2d x = PlaceOf(features[i], static_cast<std::uint32_t>(f));
      const int px = static_cast<int>(x.x() * region.width / lens[i].width),
                py = static_cast<int>(x.y() * region.height / lens[i].height);
      counts[i] +=
          *region.at(std::clamp(px, 0, region.width - 1), std::clamp(py, 0, region.height - 1)) > 0;
    }
  }
  return counts;
}

double MeanTurn(const std::vector<View>& views) {
  double sum = 0;
  std::size_t pairs = 0;
  for (std::size_t i = 0; i < views.size(); ++i)
    for (std::size_t j = i + 1; j < views.size(); ++j, ++pairs)
      sum +=
          views[i].camera_from_world.rotation.angularDistance(views[j].camera_from_world.rotation);
  return pairs > 0 ? sum / static_cast<double>(pairs) : 0;
}

}  // namespace keypose::reconstruct
