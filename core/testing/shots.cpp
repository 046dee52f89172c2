#include "core/testing/shots.h"

#include <cmath>
#include <utility>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/io/project/colmap_io.h"
#include "core/pictures/render.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/angles.h"

namespace keypose {

MaskShot MasksOf(const Mesh& mesh, std::vector<View> views) {
  const RayScene scene(mesh.points, mesh.faces);
  MaskShot shot;
  for (View& view : views) {
    const Raster raster = Rasterize(mesh, scene, view);
    Image8 mask(view.camera.width, view.camera.height, 1);
    for (std::size_t p = 0; p < mask.data.size(); ++p)
      mask.data[p] = raster.face.data[p] >= 0 ? 255 : 0;
    shot.views.push_back(std::move(view));
    shot.masks.push_back(std::move(mask));
  }
  return shot;
}

MaskShot MasksFromRings(const Mesh& mesh, const Eigen::Vector3d& middle,
                        const std::vector<double>& elevations_deg, int views_a_ring, int side_px) {
  std::vector<View> views;
  for (const double elevation : elevations_deg)
    for (int i = 0; i < views_a_ring; ++i) {
      const double a = (360.0 * i / views_a_ring + elevation) * kDegree, e = elevation * kDegree;
      View view;
      view.name = "view_" + std::to_string(views.size()) + ".png";
      view.camera.width = view.camera.height = side_px;
      view.camera.fx = view.camera.fy = 2 * side_px;
      view.camera.cx = view.camera.cy = 0.5 * side_px;
      const Eigen::Vector3d toward(std::cos(a) * std::cos(e), std::sin(a) * std::cos(e),
                                   std::sin(e));
      view.camera_from_world = LookAt(middle + 4 * toward, middle);
      views.push_back(view);
    }
  return MasksOf(mesh, std::move(views));
}

void WriteShot(const std::filesystem::path& folder, const MaskShot& shot) {
  std::filesystem::create_directories(folder / "images/masks");
  std::filesystem::create_directories(folder / "model");
  ImageSet set;
  set.folder = folder / "images";
  Scene scene;
  for (std::size_t i = 0; i < shot.views.size(); ++i) {
    CapturedImage image;
    image.name = shot.views[i].name, image.width = shot.masks[i].width,
    image.height = shot.masks[i].height;
    image.mask = "masks/" + image.name + ".png";
    WriteImage(set.folder / image.name, shot.masks[i]);
    WriteImage(set.folder / image.mask, shot.masks[i]);
    set.images.push_back(image);
    scene.views.push_back(shot.views[i]);
  }
  WriteImageSet(set);
  WriteColmapModel(folder / "model", scene);
}

}  // namespace keypose
