#include "reconstruct/sfm/turning_start.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "core/angles.h"
#include "core/io/image_set.h"
#include "core/parallel.h"
#include "core/size_of.h"
#include "core/tuned.h"
#include "reconstruct/surroundings/print_turns.h"
#include "reconstruct/surroundings/turning_plane.h"

namespace keypose::reconstruct {
namespace {

using Eigen::Vector3d;

/// Chosen on a generated room with weak paint on a mat (seed 6).
struct TurningStartTuning {
  /// of the cameras' distance: what stands in the middle of the print hides what is behind it
  KEYPOSE_TUNED(double, kStandsWithin, 0.09);
  KEYPOSE_TUNED(double, kStandsHigh, 0.45);
  KEYPOSE_TUNED(double, kTooNear, 0.03);  ///< radii of places that tell distances, of the distance
  KEYPOSE_TUNED(int, kFewestRadii, 20);
};

/// Photographs of one tripod, and the plane that turns before it.
struct Tripod {
  std::vector<int> images;
  TurningPlane plane{};
  double distance = 0;  ///< 0: not known
};

/// The tripod of each image; -1: none.
std::vector<int> TripodOf(std::size_t images, const std::vector<ImagePair>& pairs) {
  std::vector<int> of(images);
  std::iota(of.begin(), of.end(), 0);
  for (const auto& [i, j] : pairs) {
    const auto [least, other] = std::minmax({of[i], of[j]});
    std::replace(of.begin(), of.end(), other, least);
  }
  std::vector<int> size(images, 0);
  for (const int t : of) ++size[t];
  for (int& t : of)
    if (size[t] < 3) t = -1;
  return of;
}

std::optional<FlatMatches> FlatOf(const MatchedFeatures& matched, const PairMatches& pair) {
  const auto lens = [&](int image) -> const Camera& {
    return matched.lenses[matched.lens_of_image[image]];
  };
  return MatchesOnPlane(matched.features[pair.first], lens(pair.first),
                        matched.features[pair.second], lens(pair.second), pair);
}

/// The tripods before which a plane turns.
std::vector<Tripod> FindTripods(const MatchedFeatures& matched, const std::vector<int>& tripod_of) {
  std::vector<std::optional<TurningPlane>> told(matched.matches.size());
  ParallelFor(std::ssize(told), [&](std::int64_t k) {
    const PairMatches& pair = matched.matches[k];
    if (tripod_of[pair.first] < 0 || tripod_of[pair.first] != tripod_of[pair.second]) return;
    if (const auto flat = FlatOf(matched, pair)) told[k] = PlaneOfTurn(flat->homography);
  });
  std::vector<Tripod> tripods;
  for (int t = 0; t < SizeOf(tripod_of); ++t) {
    if (tripod_of[t] != t) continue;
    std::vector<TurningPlane> of_pairs;
    for (std::size_t k = 0; k < told.size(); ++k)
      if (told[k] && tripod_of[matched.matches[k].first] == t) of_pairs.push_back(*told[k]);
    const auto plane = CommonPlane(of_pairs);
    if (!plane) continue;
    tripods.push_back({{}, *plane, 0});
    for (int i = 0; i < SizeOf(tripod_of); ++i)
      if (tripod_of[i] == t) tripods.back().images.push_back(i);
  }
  return tripods;
}

/// How many times farther the second tripod is from the plane than the first: places on a print
/// keep their radius whatever turn matches them. Nothing with few matches.
std::optional<double> RatioOf(const MatchedFeatures& matched, const Tripod& first,
                              const Tripod& second) {
  const auto is_of = [](const Tripod& tripod, int image) {
    return std::find(tripod.images.begin(), tripod.images.end(), image) != tripod.images.end();
  };
  std::vector<std::vector<double>> found(matched.matches.size());
  ParallelFor(std::ssize(found), [&](std::int64_t k) {
    const PairMatches& pair = matched.matches[k];
    const bool forth = is_of(first, pair.first) && is_of(second, pair.second),
               back = is_of(second, pair.first) && is_of(first, pair.second);
    if (!forth && !back) return;
    const auto flat = FlatOf(matched, pair);
    if (!flat) return;
    for (std::size_t m = 0; m < flat->first.size(); ++m) {
      const auto a = RadiusOnPlane(first.plane, forth ? flat->first[m] : flat->second[m]),
                 b = RadiusOnPlane(second.plane, forth ? flat->second[m] : flat->first[m]);
      if (a && b && std::min(*a, *b) > TurningStartTuning::kTooNear) found[k].push_back(*a / *b);
    }
  });
  std::vector<double> ratios;
  for (const std::vector<double>& of_pair : found)
    ratios.insert(ratios.end(), of_pair.begin(), of_pair.end());
  if (SizeOf(ratios) < TurningStartTuning::kFewestRadii) return std::nullopt;
  const auto half = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
  std::nth_element(ratios.begin(), half, ratios.end());
  return *half;
}

/// Distances in units of the largest tripod's, along matches from one to the next.
void FindDistances(const MatchedFeatures& matched, std::vector<Tripod>& tripods) {
  const auto largest = std::max_element(
      tripods.begin(), tripods.end(),
      [](const auto& a, const auto& b) { return a.images.size() < b.images.size(); });
  largest->distance = 1;
  for (bool found = true; found;) {
    found = false;
    for (const Tripod& known : tripods)
      for (Tripod& tripod : tripods) {
        if (known.distance == 0 || tripod.distance > 0) continue;
        if (const auto ratio = RatioOf(matched, known, tripod)) {
          tripod.distance = known.distance * *ratio;
          found = true;
        }
      }
  }
}

/// What may stand in the middle, seen by all.
std::vector<SparsePoint> Standing(double distance, std::size_t views) {
  constexpr int kAround = 16, kUp = 8;
  std::vector<int> all(views);
  std::iota(all.begin(), all.end(), 0);
  std::vector<SparsePoint> points;
  for (int up = 1; up <= kUp; ++up)
    for (int ring = 0; ring <= 2; ++ring)
      for (int k = 0; k < kAround; ++k) {
        const double angle = 2 * kPi * k / kAround,
                     radius = 0.5 * ring * TurningStartTuning::kStandsWithin * distance;
        SparsePoint point{};
        point.position = {radius * std::cos(angle), radius * std::sin(angle),
                          TurningStartTuning::kStandsHigh * distance * up / kUp};
        point.views = all;
        points.push_back(std::move(point));
      }
  return points;
}

}  // namespace

std::optional<Scene> CamerasOverTurningPrint(const StrategyContext& context,
                                             const PrintPictures& pictures,
                                             const MatchedFeatures& matched) {
  const std::vector<int> tripod_of = TripodOf(matched.features.size(), matched.tripod_pairs);
  std::vector<Tripod> tripods = FindTripods(matched, tripod_of);
  if (tripods.empty()) return std::nullopt;
  FindDistances(matched, tripods);
  Scene scene;
  std::vector<Image8> photographs, regions;
  std::vector<double> distances;
  std::vector<std::pair<int, const Tripod*>> of_image;
  for (const Tripod& tripod : tripods)
    for (const int image : tripod.images)
      if (tripod.distance > 0) of_image.emplace_back(image, &tripod);
  std::sort(of_image.begin(), of_image.end());
  for (const auto& [image, tripod] : of_image) {
    scene.views.push_back({context.set.images[image].name,
                           matched.lenses[matched.lens_of_image[image]],
                           CameraOver(tripod->plane, tripod->distance)});
    photographs.push_back(pictures.photographs[image]);
    regions.push_back(pictures.regions[image]);
    distances.push_back(tripod->distance);
  }
  if (scene.views.size() < 3) return std::nullopt;
  const auto half = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), half, distances.end());
  SupportPlane plane;
  plane.distance = *half;
  scene.points = Standing(plane.distance, scene.views.size());
  PrintTurnOptions options;
  options.clearly = 2;  // where they are turned now says nothing
  const PrintTurns turns = FindPrintTurns(scene, photographs, regions, plane, options);
  Scene turned;
  for (std::size_t v = 0; v < scene.views.size(); ++v)
    if (turns.knows[v])
      turned.views.push_back(
          TurnedWithPrint(scene.views[v], turns.turn[v], plane.normal, turns.middle));
  context.stage.Note("sfm: a plane turns before " + std::to_string(tripods.size()) +
                     " tripods; its print tells the turns of " +
                     std::to_string(turned.views.size()) + " of " +
                     std::to_string(context.set.images.size()) + " photographs");
  return turned;
}

}  // namespace keypose::reconstruct
