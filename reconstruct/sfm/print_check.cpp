#include "reconstruct/sfm/print_check.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "core/angles.h"
#include "core/io/image_set.h"
#include "core/io/reduced_image.h"
#include "core/parallel.h"
#include "core/tuned.h"
#include "reconstruct/matching/verification.h"
#include "reconstruct/numerics/epipolar.h"
#include "reconstruct/surroundings/print_turns.h"
#include "reconstruct/surroundings/support_plane.h"

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
      if (shared[v][k] > 0 && with > most) most = with, found.turn[v] = found.turn[k];
    }
  }
}

}  // namespace

PrintCheck CheckPrint(const StrategyContext& context, const std::vector<Image8>& regions,
                      const Scene& scene) {
  PrintCheck check{scene, 0, 0, std::vector<char>(context.set.images.size(), 0)};
  const auto plane = PlaneUnder(context.set, scene);
  if (!plane) return check;
  const std::size_t views = scene.views.size();
  std::vector<Image8> pictures(views), seen(views);
  std::vector<int> image(views);
  ParallelFor(std::ssize(scene.views), [&](std::int64_t v) {
    image[v] = context.set.Find(scene.views[v].name);
    pictures[v] = ReadReducedTo(context.set.ImagePath(image[v]), 3, PrintCheckTuning::kPicturePx);
    seen[v] = regions[image[v]];
  });
  PrintTurns found = FindPrintTurns(scene, pictures, seen, *plane);
  check.known = static_cast<int>(std::count(found.knows.begin(), found.knows.end(), 1));
  TurnWithOthers(scene, found);
  for (std::size_t v = 0; v < views; ++v) {
    if (found.turn[v] == 0) continue;
    ++check.turned;
    check.is_turned[image[v]] = 1;
    check.scene.views[v] =
        TurnedWithPrint(scene.views[v], found.turn[v], plane->normal, found.middle);
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
  std::vector<PairMatches> kept, gone;
  for (PairMatches& pair : matched.verified) {
    const bool placed = view_of[pair.first] >= 0 && view_of[pair.second] >= 0;
    if (placed) pair.features.clear();
    (placed ? gone : kept).push_back(std::move(pair));
  }
  for (std::optional<Verified>& pair : fitting)
    if (pair) kept.push_back(std::move(pair->inliers));
  ColmapDatabase database(files.database);
  database.PutInliers(gone);
  database.PutInliers(kept);
  matched.verified = std::move(kept);
}

void ForgetMatchesOf(const std::vector<char>& images, const SfmFiles& files,
                     MatchedFeatures& matched) {
  std::vector<PairMatches> gone;
  std::erase_if(matched.verified, [&](const PairMatches& pair) {
    if (!images[pair.first] && !images[pair.second]) return false;
    gone.push_back({pair.first, pair.second, {}});
    return true;
  });
  ColmapDatabase(files.database).PutInliers(gone);
}

}  // namespace keypose::reconstruct
