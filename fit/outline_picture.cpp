#include "fit/outline_picture.h"

#include <algorithm>
#include <cmath>

#include "core/pictures/render.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/size_of.h"
#include "fit/contours/contours.h"

namespace keypose::fit {
namespace {

constexpr int kColumns = 3;
constexpr std::uint8_t kLine[3] = {60, 255, 60}, kPick[3] = {255, 60, 200};

/// A dot of two by two pixels.
void Dot(Image8& picture, const Eigen::Vector2d& at, const std::uint8_t (&color)[3]) {
  const int x = static_cast<int>(std::floor(at.x())), y = static_cast<int>(std::floor(at.y()));
  for (int k = 0; k < 4; ++k) {
    const int px = x + k % 2, py = y + k / 2;
    if (px < 0 || py < 0 || px >= picture.width || py >= picture.height) continue;
    for (int c = 0; c < 3; ++c) picture.at(px, py)[c] = color[c];
  }
}

void DrawSegment(Image8& picture, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const int steps = static_cast<int>(std::ceil((b - a).norm()));
  for (int k = 0; k <= steps; ++k)
    Dot(picture, a + (b - a) * (steps > 0 ? static_cast<double>(k) / steps : 0), kPick);
}

/// A cross at the pick, and a line to where the template shows its place.
void DrawPick(Image8& picture, const Eigen::Vector2d& pick, const Eigen::Vector2d& shown) {
  const double arm = std::max(4.0, picture.width / 100.0);
  DrawSegment(picture, pick - Eigen::Vector2d(arm, arm), pick + Eigen::Vector2d(arm, arm));
  DrawSegment(picture, pick - Eigen::Vector2d(arm, -arm), pick + Eigen::Vector2d(arm, -arm));
  if ((shown - pick).norm() < picture.width + picture.height) DrawSegment(picture, pick, shown);
}

}  // namespace

Image8 OutlinePicture(const Mesh& mesh, const std::vector<BendView>& views,
                      const std::vector<Rigid3>& cameras, const std::vector<PixelPick>& picks) {
  const RayScene scene(mesh.points, mesh.faces);
  const FacePairs pairs = FindFacePairs(mesh.faces);
  std::vector<Image8> pictures;
  for (int v = 0; v < SizeOf(views); ++v) {
    Image8 picture = views[v].view.color;
    const Pinhole& camera = views[v].view.camera();
    for (const ContourPoint& point :
         FindSilhouette(mesh.points, mesh.faces, pairs, scene, camera, cameras[v])) {
      const Eigen::Vector2d along(-point.normal.y(), point.normal.x());
      const int steps = static_cast<int>(std::ceil(point.length_px));
      for (int k = 0; k <= steps; ++k)
        Dot(picture, point.pixel + (static_cast<double>(k) / steps - 0.5) * point.length_px * along,
            kLine);
    }
    for (const PixelPick& mark : picks)
      if (mark.view == v)
        DrawPick(picture, mark.pixel,
                 camera.Project(cameras[v] * PositionOf(mark.point, mesh.points)));
    pictures.push_back(std::move(picture));
  }
  return TileImages(pictures, std::min(kColumns, SizeOf(pictures)));
}

}  // namespace keypose::fit
