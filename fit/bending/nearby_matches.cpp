#include "fit/bending/nearby_matches.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::fit {
namespace {

// Chosen on the clay creature's seeds 1 to 4 (synth).
struct NearbyMatchesTuning {
  KEYPOSE_TUNED(double, kRatio, 0.8);     // a match must beat other places nearby by this
  KEYPOSE_TUNED(double, kApart, 6);       // distance between different places [px]
  KEYPOSE_TUNED(double, kSimilar, 0.88);  // least cosine of the descriptors
  KEYPOSE_TUNED(double, kOrdinary, 0.8);  // cosine that some other place always has
};

constexpr int kRenderFeatures = 4000;

/// The render as a picture, with its mean where nothing is hit, so that outlines give few features.
Image8 PictureOf(const TexturedRender& render) {
  double sum = 0;
  int hit = 0;
  for (std::size_t i = 0; i < render.face.data.size(); ++i)
    if (render.face.data[i] >= 0) {
      sum += render.grey.data[i];
      ++hit;
    }
  const double mean = hit > 0 ? sum / hit : 0;
  Image8 picture(render.grey.width, render.grey.height, 1);
  for (std::size_t i = 0; i < picture.data.size(); ++i)
    picture.data[i] = static_cast<std::uint8_t>(std::lround(
        std::clamp<double>(render.face.data[i] >= 0 ? render.grey.data[i] : mean, 0, 255)));
  return picture;
}

struct Candidate {
  int feature = -1;
  double similarity = -1, second = -1;
};

/// The most similar photo feature within reach, and the best at another place within reach.
Candidate BestNear(const PictureFeatures& photo, const Eigen::Vector2d& pixel,
                   const Eigen::RowVectorXf& descriptor, double reach_px) {
  Candidate best;
  std::vector<std::pair<double, int>> near;
  for (int i = 0; i < SizeOf(photo.pixels); ++i)
    if ((photo.pixels[i] - pixel).squaredNorm() <= reach_px * reach_px)
      near.emplace_back(photo.descriptors.row(i).dot(descriptor), i);
  for (const auto& [similarity, i] : near)
    if (similarity > best.similarity) {
      best.similarity = similarity;
      best.feature = i;
    }
  for (const auto& [similarity, i] : near)
    if ((photo.pixels[i] - photo.pixels[best.feature]).norm() > NearbyMatchesTuning::kApart)
      best.second = std::max(best.second, similarity);
  return best;
}

}  // namespace

std::vector<FeatureMatch> MatchNearby(const FacesX3& faces, const RayScene& scene,
                                      const TexturedRender& render, const FitView& view,
                                      const PictureFeatures& photo, double reach_px) {
  const PictureFeatures own = FindFeatures(PictureOf(render), {}, kRenderFeatures);
  const Eigen::Vector3d eye = view.Center();
  std::map<int, FeatureMatch> of_photo;  // by the photograph's feature, the best
  for (int i = 0; i < SizeOf(own.pixels); ++i) {
    const Eigen::Vector2d& pixel = own.pixels[i];
    const RayScene::Hit hit = scene.Cast(
        eye, view.camera_from_world.rotation.conjugate() * view.camera.Ray(pixel.x(), pixel.y()));
    if (hit.face < 0) continue;
    const Candidate best = BestNear(photo, pixel, own.descriptors.row(i), reach_px);
    if (best.feature < 0 || best.similarity < NearbyMatchesTuning::kSimilar) continue;
    const double ratio =
        std::sqrt(std::max(0.0, 1 - best.similarity) /
                  std::max(1e-6, 1 - std::max(best.second, NearbyMatchesTuning::kOrdinary)));
    if (ratio > NearbyMatchesTuning::kRatio) continue;
    FeatureMatch match{{faces.row(hit.face).transpose(), {1 - hit.u - hit.v, hit.u, hit.v}},
                       photo.pixels[best.feature],
                       best.similarity,
                       ratio};
    const auto [at, added] = of_photo.emplace(best.feature, match);
    if (!added && ratio < at->second.ratio) at->second = match;
  }
  std::vector<FeatureMatch> matches;
  for (const auto& [feature, match] : of_photo) matches.push_back(match);
  return matches;
}

}  // namespace keypose::fit
