#include "reconstruct/sfm/print_check.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "core/io/pictures/image_set.h"
#include "core/io/pictures/reduced_image.h"
#include "core/numbers/parallel.h"
#include "core/values/angles.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "reconstruct/matching/verification.h"
#include "reconstruct/numerics/epipolar.h"
#include "reconstruct/surroundings/print_turns.h"
#include "reconstruct/surroundings/support_plane.h"
#include "views/placement/picture_pose.h"

namespace keypose::reconstruct {
namespace {

/// Chosen on generated rooms with a turning mat or disc (seeds 3, 4 and 9).
struct PrintCheckTuning {
  KEYPOSE_TUNED(int, kPicturePx, 800);    ///< longer side of the photographs that are drawn
  KEYPOSE_TUNED(double, kFitsPx, 8);      ///< from the epipolar line: turned cameras are not exact
  KEYPOSE_TUNED(double, kSameTurn, 0.1);  ///< [rad]
};

bool FitsCameras(const View& a, const View& b, const Eigen::Matrix3d& essential,
                 const Features& first, std::uint32_t i, const Features& second, std::uint32_t j,
                 double limit) {
  return SquaredSampson(essential, a.camera.Unproject(first.positions.row(i).cast<double>()),
                        b.camera.Unproject(second.positions.row(j).cast<double>())) < limit * limit;
}

/// The raw matches of a pair that lie near the epipolar lines of its cameras.
PairMatches MatchesAlong(const View& a, const View& b, const MatchedFeatures& matched,
                         const PairMatches& raw) {
  const Rigid3 &pose_a = a.camera_from_world, &pose_b = b.camera_from_world;
  const Eigen::Matrix3d essential =
      EssentialOf(pose_a.rotation.toRotationMatrix(), pose_a.translation,
                  pose_b.rotation.toRotationMatrix(), pose_b.translation);
  const double limit = PrintCheckTuning::kFitsPx / a.camera.fx;
  PairMatches pair = raw;
  std::erase_if(pair.features, [&](const auto& match) {
    return !FitsCameras(a, b, essential, matched.features[pair.first], match.first,
                        matched.features[pair.second], match.second, limit);
  });
  return pair;
}

/// Upwards, by cameras that were held upright in the mean.
std::optional<Eigen::Vector3d> UpOf(const ImageSet& set, const Scene& scene) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const View& view : scene.views)
    if (!LiesAcross(set.images[set.Find(view.name)]))
      sum -= view.camera_from_world.rotation.conjugate() * Eigen::Vector3d::UnitY();
  if (sum.norm() < 0.3 * static_cast<double>(scene.views.size())) return std::nullopt;
  return sum.normalized();
}

/// The plane under the figure. Where cameras are wrong its points are few and doubled.
std::optional<SupportPlane> PlaneUnder(const ImageSet& set, const Scene& scene) {
  if (scene.views.size() < 3) return std::nullopt;
  SupportPlaneOptions options;
  options.share = 0.05;
  options.up = UpOf(set, scene);
  return FindSupportPlane(scene, options);
}

/// Close looks show too little of a print: they were placed by what they share with the others, and
/// are turned with those that they share most points with.
void TurnWithOthers(const Scene& scene, PrintTurns& found) {
  const std::size_t views = scene.views.size();
  std::vector<std::vector<int>> shared(views, std::vector<int>(views, 0));
  for (const SparsePoint& point : scene.points)
    for (const int a : point.views)
      if (!found.knows[a])
        for (const int b : point.views) shared[a][b] += found.knows[b];
  const auto near = [](double a, double b) {
    return std::abs(std::remainder(a - b, 2 * kPi)) < PrintCheckTuning::kSameTurn;
  };
  for (std::size_t v = 0; v < views; ++v) {
    if (found.knows[v]) continue;
    int most = 0;
    for (std::size_t k = 0; k < views; ++k) {
      int with = 0;
      for (std::size_t other = 0; other < views; ++other)
        if (shared[v][other] > 0 && near(found.turn[k], found.turn[other]))
          with += shared[v][other];
      if (shared[v][k] > 0 && with > most) {
        most = with;
        found.turn[v] = found.turn[k];
      }
    }
  }
}

/// Places on the plane, and where a photograph shows them.
struct SeenOnPlane {
  std::vector<Eigen::Vector3d> places;
  std::vector<FeatureMatch> matches;  ///< of places, as vertices
};

/// Without the distortion of the lens.
Pinhole PinholeOf(const Camera& lens) {
  return {lens.width, lens.height, lens.fx, lens.fy, lens.cx, lens.cy};
}

/// Adds what a view shows of the plane at its matches with a photograph.
/// @param of_view, of_image  features' sides of the pair's matches
void AddSeen(const View& view, const Features& of_view, const Features& of_image,
             const Camera& lens, const PairMatches& pair, bool view_is_first,
             const SupportPlane& plane, SeenOnPlane& seen) {
  const double reach = PrintTurnOptions{}.radius * plane.distance;
  const Eigen::Quaterniond to_world = view.camera_from_world.rotation.conjugate();
  const Eigen::Vector3d center = view.Center();
  for (const auto& [first, second] : pair.features) {
    const auto f = view_is_first ? first : second, g = view_is_first ? second : first;
    const Eigen::Vector3d ray =
        to_world * view.camera.Unproject(of_view.positions.row(f).transpose().cast<double>());
    const double along = (plane.offset - plane.normal.dot(center)) / plane.normal.dot(ray);
    const Eigen::Vector3d at = center + along * ray;
    if (!(along > 0) || (at - plane.foot).norm() > reach) continue;
    const Eigen::Vector3d sight =
        lens.Unproject(of_image.positions.row(g).transpose().cast<double>());
    FeatureMatch match;
    match.point.vertices.setConstant(SizeOf(seen.places));
    match.pixel = PinholeOf(lens).Project(sight);
    seen.places.push_back(at);
    seen.matches.push_back(match);
  }
}

/// The camera that most of these places fit; they may be of another turn of the print.
std::optional<Rigid3> PoseBy(const SeenOnPlane& seen, const Camera& lens) {
  constexpr int kFewest = 12;
  PointsX3 places(std::ssize(seen.places), 3);
  for (Eigen::Index i = 0; i < places.rows(); ++i) places.row(i) = seen.places[i];
  const PicturePose pose =
      PlacePicture(PinholeOf(lens), places, seen.matches, PrintCheckTuning::kFitsPx, kFewest);
  if (!pose.found) return std::nullopt;
  return pose.camera_from_world;
}

/// Cameras of photographs that have none, by what others with one show of the plane.
std::vector<View> GuestsOn(const StrategyContext& context, const Scene& scene,
                           const MatchedFeatures& matched, const SupportPlane& plane) {
  const std::vector<int> view_of = context.check.ViewOfImage(scene);
  const std::size_t images = view_of.size();
  std::vector<std::optional<View>> guests(images);
  ParallelFor(std::ssize(view_of), [&](std::int64_t i) {
    if (view_of[i] >= 0) return;
    Camera lens = matched.lenses[matched.lens_of_image[i]];
    // The lens as the model's views of it have it.
    for (std::size_t k = 0; k < images; ++k)
      if (view_of[k] >= 0 && matched.lens_of_image[k] == matched.lens_of_image[i])
        lens = scene.views[view_of[k]].camera;
    SeenOnPlane seen;
    for (const PairMatches& pair : matched.matches) {
      const bool first = pair.second == i && view_of[pair.first] >= 0,
                 second = pair.first == i && view_of[pair.second] >= 0;
      if (!first && !second) continue;
      const int other = first ? pair.first : pair.second;
      AddSeen(scene.views[view_of[other]], matched.features[other], matched.features[i], lens, pair,
              first, plane, seen);
    }
    if (const auto pose = PoseBy(seen, lens))
      guests[i] = View{context.set.images[i].name, lens, *pose};
  });
  std::vector<View> found;
  for (std::optional<View>& guest : guests)
    if (guest && plane.normal.dot(guest->Center()) > plane.offset)
      found.push_back(std::move(*guest));
  return found;
}

}  // namespace

PrintPictures PicturesForPrint(const ImageSet& set, const std::vector<Image8>& regions) {
  PrintPictures pictures{std::vector<Image8>(set.images.size()), regions};
  ParallelFor(std::ssize(set.images), [&](std::int64_t i) {
    pictures.photographs[i] =
        ReadReducedTo(set.ImagePath(static_cast<int>(i)), 3, PrintCheckTuning::kPicturePx);
  });
  return pictures;
}

PrintCheck CheckPrint(const StrategyContext& context, const PrintPictures& pictures,
                      const Scene& scene, const MatchedFeatures& matched) {
  PrintCheck check{scene, 0, 0, 0, std::vector<char>(context.set.images.size(), 0)};
  const auto plane = PlaneUnder(context.set, scene);
  if (!plane) return check;
  Scene all = scene;
  for (View& guest : GuestsOn(context, scene, matched, *plane))
    all.views.push_back(std::move(guest));
  const std::size_t views = all.views.size();
  std::vector<Image8> photographs, regions;
  std::vector<int> image;
  for (const View& view : all.views) {
    image.push_back(context.set.Find(view.name));
    photographs.push_back(pictures.photographs[image.back()]);
    regions.push_back(pictures.regions[image.back()]);
  }
  PrintTurns found = FindPrintTurns(all, photographs, regions, *plane);
  check.known = static_cast<int>(
      std::count(found.knows.begin(), found.knows.begin() + std::ssize(scene.views), 1));
  TurnWithOthers(scene, found);
  for (std::size_t v = 0; v < views; ++v) {
    const View view = TurnedWithPrint(all.views[v], found.turn[v], plane->normal, found.middle);
    if (v >= scene.views.size()) {
      if (!found.knows[v]) continue;
      ++check.guests;
      check.scene.views.push_back(view);
    } else if (found.turn[v] != 0) {
      ++check.turned;
      check.is_turned[image[v]] = 1;
      check.scene.views[v] = view;
    }
  }
  return check;
}

void KeepMatchesOf(const StrategyContext& context, const Scene& scene, const SfmFiles& files,
                   MatchedFeatures& matched) {
  const std::vector<int> view_of = context.check.ViewOfImage(scene);
  VerificationOptions options;
  options.min_inliers = context.options.min_inliers;
  const std::size_t raw = matched.matches.size();
  std::vector<std::optional<Verified>> fitting(raw);
  ParallelFor(std::ssize(matched.matches), [&](std::int64_t k) {
    const PairMatches& pair = matched.matches[k];
    const int a = view_of[pair.first], b = view_of[pair.second];
    if (a < 0 || b < 0) return;
    const PairMatches along = MatchesAlong(scene.views[a], scene.views[b], matched, pair);
    if (std::ssize(along.features) < options.min_inliers) return;
    fitting[k] =
        VerifyPair(matched.features[pair.first], matched.features[pair.second], along, options);
  });
  std::vector<PairMatches> kept;
  for (const PairMatches& pair : matched.verified)
    if (view_of[pair.first] < 0 || view_of[pair.second] < 0) kept.push_back(pair);
  for (std::optional<Verified>& pair : fitting)
    if (pair) kept.push_back(std::move(pair->inliers));
  ReplaceVerified(std::move(kept), files, matched);
}

void ForgetMatchesOf(const std::vector<char>& images, const SfmFiles& files,
                     MatchedFeatures& matched) {
  std::vector<PairMatches> kept = matched.verified;
  std::erase_if(kept,
                [&](const PairMatches& pair) { return images[pair.first] || images[pair.second]; });
  ReplaceVerified(std::move(kept), files, matched);
}

}  // namespace keypose::reconstruct
