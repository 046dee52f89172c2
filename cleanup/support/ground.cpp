#include "cleanup/support/ground.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/pictures/ground_contact.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/tuned.h"

namespace keypose::cleanup {
namespace {

using Eigen::Vector3d;

// Chosen on the synthetic figures whose soles docs/results/cleanup.md measures (demo, columns,
// clay, hand on the hip), with room beyond the largest values there.
struct StandingTuning {
  // of the figure's height: distance of the contact from z = 0; the largest in the known sets is
  // 0.005
  KEYPOSE_TUNED(double, kNear, 0.01);
  // of the figure's height, below the ground: for a base as wide as high, seen from 25 degrees, it
  // is 0.1
  KEYPOSE_TUNED(double, kDeepestBelow, 1.0 / 6);
  // of the figure's height: surface that is visible below this depth is not a rounded edge
  KEYPOSE_TUNED(double, kBelow, 0.0075);
  // of the figure's height, below a board: nothing can be there, so it is an error of the masks.
  // The largest on the rendered boards of 800 px is 0.016
  KEYPOSE_TUNED(double, kBelowBoard, 0.03);
  KEYPOSE_TUNED(double, kFromBelow, 0.09);  // slope from which on a camera looks up: 5 degrees
  KEYPOSE_TUNED(int, kSeen_px, 12);         // px of a photograph: fewer below the ground are noise
};
constexpr int kStride = 2;

bool AnyLooksUp(const std::vector<View>& views, const Vector3d& middle) {
  return std::any_of(views.begin(), views.end(), [&](const View& view) {
    const Vector3d from = view.Center() - middle;
    return from.z() + middle.z() < -StandingTuning::kFromBelow * from.head<2>().norm();
  });
}

/// The number of a mask's pixels that show the surface below a height.
int PixelsBelow(const RayScene& scene, const View& view, const Image8& mask, double height) {
  const Camera camera = view.camera.Scaled(static_cast<double>(mask.width) / view.camera.width);
  const Vector3d origin = view.Center();
  int count = 0;
  for (int y = kStride / 2; y < mask.height; y += kStride)
    for (int x = kStride / 2; x < mask.width; x += kStride) {
      if (*mask.at(x, y) <= 127) continue;
      const Vector3d ray =
          view.camera_from_world.rotation.conjugate() * camera.Unproject({x + 0.5, y + 0.5});
      const RayScene::Hit hit = scene.Cast(origin, ray);
      if (hit.face >= 0 && origin.z() + hit.distance * ray.z() < height) ++count;
    }
  return kStride * kStride * count;
}

/// The 75 % quantile over the photographs of the pixels below the height: other cameras may be too
/// high to see it.
int SeenBelow(const Mesh& surface, const std::vector<View>& views, const std::vector<Image8>& masks,
              double height) {
  const RayScene scene(surface.points, surface.faces);
  std::vector<int> counts(views.size(), -1);
  ParallelFor(std::ssize(views), [&](std::int64_t i) {
    const auto v = static_cast<std::size_t>(i);
    if (!masks[v].empty()) counts[v] = PixelsBelow(scene, views[v], masks[v], height);
  });
  std::erase(counts, -1);
  return QuantileAbove(std::move(counts), 0.75);
}

}  // namespace

Standing StandsOnGround(const Mesh& surface, const std::vector<View>& views,
                        const std::vector<Image8>& masks, GroundKind kind) {
  using Tuning = StandingTuning;
  Standing standing;
  const Vector3d low = surface.points.colwise().minCoeff().transpose(),
                 high = surface.points.colwise().maxCoeff().transpose();
  const double tall = high.z() - std::max(low.z(), 0.0);
  if (!(tall > 0)) return {false, 0, "it lies below z = 0"};
  if (AnyLooksUp(views, (low + high) / 2))
    return {false, 0, "photographs from below show its underside"};
  if (kind == GroundKind::kFloor) return {true, 0, ""};
  const bool on_board = kind == GroundKind::kBoard;
  const auto contact = FindGroundContact(
      views, masks, Vector3d(low.x(), low.y(), std::max(low.z(), -Tuning::kDeepestBelow * tall)),
      high);
  if (!contact) return {false, 0, "the photographs do not show where it stands"};
  standing.contact = contact->height;
  const double below = on_board ? Tuning::kBelowBoard : Tuning::kBelow;
  if (contact->height > Tuning::kNear * tall ||
      -contact->height > (on_board ? Tuning::kBelowBoard : Tuning::kNear) * tall)
    standing.why = "its outlines do not end at z = 0";
  else if (-low.z() > Tuning::kDeepestBelow * tall)
    standing.why = "the surface reaches far below z = 0";
  else if (low.z() < -below * tall &&
           SeenBelow(surface, views, masks, -below * tall) > Tuning::kSeen_px)
    standing.why = "photographs show a part of it below z = 0";
  standing.stands = standing.why.empty();
  return standing;
}

}  // namespace keypose::cleanup
