#include "reconstruct/surroundings/turning_cameras.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/values/angles.h"
#include "core/values/size_of.h"
#include "core/values/union_find.h"
#include "reconstruct/surroundings/print_turns.h"
#include "reconstruct/surroundings/turning_plane.h"

namespace keypose::reconstruct {
namespace {

using Eigen::Vector3d;

// Chosen on a generated room with weak paint on a mat (seed 6). What stands in the middle of the
// print hides what is behind it; its size is of the cameras' distance.
constexpr double kStandsWithin = 0.09, kStandsHigh = 0.45;
constexpr double kTooNear = 0.03;  // radii of places that tell distances, of the distance
constexpr int kFewestRadii = 20;
constexpr double kUnturned = 0.2;  // [rad]

/// Photographs of one tripod, and the plane that turns before it.
struct Tripod {
  std::vector<int> images;
  TurningPlane plane{};
  double distance = 0;  ///< 0: not known
};

/// The tripod of each image; -1: none.
std::vector<int> TripodOf(std::size_t images, const std::vector<ImagePair>& pairs) {
  UnionFind sets(static_cast<std::ptrdiff_t>(images));
  for (const auto& [i, j] : pairs) sets.Join(i, j);
  std::vector<int> of(images), size(images, 0);
  for (int i = 0; i < SizeOf(of); ++i) ++size[of[i] = sets.Find(i)];
  for (int& t : of)
    if (size[t] < 3) t = -1;
  return of;
}

std::optional<FlatMatches> FlatOf(const BeforeTripods& set, const PairMatches& pair) {
  return MatchesOnPlane(set.features[pair.first], set.lenses[pair.first], set.features[pair.second],
                        set.lenses[pair.second], pair);
}

/// The tripods before which a plane turns.
std::vector<Tripod> FindTripods(const BeforeTripods& set, const std::vector<int>& tripod_of) {
  std::vector<std::optional<TurningPlane>> told(set.matches.size());
  ParallelFor(std::ssize(told), [&](std::int64_t k) {
    const PairMatches& pair = set.matches[k];
    if (tripod_of[pair.first] < 0 || tripod_of[pair.first] != tripod_of[pair.second]) return;
    if (const auto flat = FlatOf(set, pair)) told[k] = PlaneOfTurn(flat->homography);
  });
  std::vector<Tripod> tripods;
  for (int t = 0; t < SizeOf(tripod_of); ++t) {
    if (tripod_of[t] != t) continue;
    std::vector<TurningPlane> of_pairs;
    for (std::size_t k = 0; k < told.size(); ++k)
      if (told[k] && tripod_of[set.matches[k].first] == t) of_pairs.push_back(*told[k]);
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
std::optional<double> RatioOf(const BeforeTripods& set, const Tripod& first, const Tripod& second) {
  const auto is_of = [](const Tripod& tripod, int image) {
    return std::find(tripod.images.begin(), tripod.images.end(), image) != tripod.images.end();
  };
  std::vector<std::vector<double>> found(set.matches.size());
  ParallelFor(std::ssize(found), [&](std::int64_t k) {
    const PairMatches& pair = set.matches[k];
    const bool forth = is_of(first, pair.first) && is_of(second, pair.second),
               back = is_of(second, pair.first) && is_of(first, pair.second);
    if (!forth && !back) return;
    const auto flat = FlatOf(set, pair);
    if (!flat) return;
    for (std::size_t m = 0; m < flat->first.size(); ++m) {
      const auto a = RadiusOnPlane(first.plane, forth ? flat->first[m] : flat->second[m]),
                 b = RadiusOnPlane(second.plane, forth ? flat->second[m] : flat->first[m]);
      if (a && b && std::min(*a, *b) > kTooNear) found[k].push_back(*a / *b);
    }
  });
  std::vector<double> ratios;
  for (const std::vector<double>& of_pair : found)
    ratios.insert(ratios.end(), of_pair.begin(), of_pair.end());
  if (SizeOf(ratios) < kFewestRadii) return std::nullopt;
  return UpperMedian(std::move(ratios));
}

/// Distances in units of the largest tripod's, along matches from one to the next.
void FindDistances(const BeforeTripods& set, std::vector<Tripod>& tripods) {
  const auto largest = std::max_element(
      tripods.begin(), tripods.end(),
      [](const auto& a, const auto& b) { return a.images.size() < b.images.size(); });
  largest->distance = 1;
  for (bool found = true; found;) {
    found = false;
    for (const Tripod& known : tripods)
      for (Tripod& tripod : tripods) {
        if (known.distance == 0 || tripod.distance > 0) continue;
        if (const auto ratio = RatioOf(set, known, tripod)) {
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
        const double angle = 2 * kPi * k / kAround, radius = 0.5 * ring * kStandsWithin * distance;
        SparsePoint point;
        point.color.setZero();
        point.position = {radius * std::cos(angle), radius * std::sin(angle),
                          kStandsHigh * distance * up / kUp};
        point.views = all;
        points.push_back(std::move(point));
      }
  return points;
}

double MedianDistance(const std::vector<Tripod>& tripods) {
  std::vector<double> distances;
  for (const Tripod& tripod : tripods)
    if (tripod.distance > 0)
      distances.insert(distances.end(), tripod.images.size(), tripod.distance);
  return UpperMedian(std::move(distances));
}

/// The tripod of each photograph that has one with a known distance.
std::vector<const Tripod*> ByImage(std::size_t images, const std::vector<Tripod>& tripods) {
  std::vector<const Tripod*> of(images, nullptr);
  for (const Tripod& tripod : tripods)
    for (const int image : tripod.images)
      if (tripod.distance > 0) of[image] = &tripod;
  return of;
}

}  // namespace

std::optional<TurningCameras> CamerasOverTurningPrint(const BeforeTripods& set,
                                                      const std::vector<Image8>& pictures,
                                                      const std::vector<Image8>& regions) {
  const std::vector<int> tripod_of = TripodOf(set.features.size(), set.pairs);
  std::vector<Tripod> tripods = FindTripods(set, tripod_of);
  if (tripods.empty()) return std::nullopt;
  FindDistances(set, tripods);
  const std::vector<const Tripod*> of_image = ByImage(set.features.size(), tripods);
  Scene scene;
  std::vector<Image8> shown, carries;
  for (std::size_t image = 0; image < of_image.size(); ++image) {
    const Tripod* tripod = of_image[image];
    if (!tripod) continue;
    scene.views.push_back(
        {set.names[image], set.lenses[image], CameraOver(tripod->plane, tripod->distance)});
    shown.push_back(pictures[image]);
    carries.push_back(regions[image]);
  }
  SupportPlane plane;
  plane.distance = MedianDistance(tripods);
  scene.points = Standing(plane.distance, scene.views.size());
  PrintTurnOptions options;
  options.clearly = 2;  // where they are turned now says nothing
  options.unturned = kUnturned;
  const PrintTurns turns = FindPrintTurns(scene, shown, carries, plane, options);
  TurningCameras found;
  found.tripods = SizeOf(tripods);
  for (std::size_t v = 0; v < scene.views.size(); ++v)
    if (turns.knows[v])
      found.scene.views.push_back(
          TurnedWithPrint(scene.views[v], turns.turn[v], plane.normal, turns.middle));
  return found;
}

}  // namespace keypose::reconstruct
