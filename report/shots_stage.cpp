#include "report/shots_stage.h"

#include <algorithm>
#include <cmath>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/io/pictures/reduced_image.h"
#include "core/numbers/parallel.h"
#include "core/pictures/undistorted.h"

namespace keypose::report {
namespace {

namespace fs = std::filesystem;

Image8 BothMasks(const fs::path& first, const fs::path& last, const Camera& size) {
  const int longer = std::max(size.width, size.height);
  Image8 both = Resized(ReadReducedTo(first, 1, longer), size.width, size.height);
  const Image8 other = Resized(ReadReducedTo(last, 1, longer), size.width, size.height);
  for (std::size_t i = 0; i < both.data.size(); ++i)
    both.data[i] = std::min(both.data[i], other.data[i]);
  return both;
}

/// Of a picture of that size, which may be a pixel off the camera's.
Camera Sized(const Camera& camera, const Image8& picture) {
  Camera sized = camera.Scaled(static_cast<double>(std::max(picture.width, picture.height)) /
                               std::max(camera.width, camera.height));
  sized.width = picture.width;
  sized.height = picture.height;
  return sized;
}

}  // namespace

Shot ReadShot(const View& view, const fs::path& photograph, const fs::path& mask, int longer_px) {
  Shot shot{view, ReadReducedTo(photograph, 3, longer_px), ReadReducedTo(mask, 1, longer_px)};
  Camera& camera = shot.view.camera;
  camera = Sized(camera, shot.photograph);
  if (shot.mask.width != camera.width || shot.mask.height != camera.height)
    shot.mask = Resized(shot.mask, camera.width, camera.height);
  return shot;
}

std::vector<CoveredMask> CoveredMasks(const Mesh& mesh, const RayScene& scene, const Scene& cameras,
                                      const ImageSet& first, const ImageSet& last) {
  constexpr double kLongerSide = 400;
  std::vector<CoveredMask> views;
  for (const View& view : cameras.views) {
    const int i = first.Find(view.name), k = last.Find(view.name);
    if (i >= 0 && k >= 0 && !first.images[i].mask.empty() && !last.images[k].mask.empty())
      views.push_back({view, {}, {}});
  }
  ParallelFor(std::ssize(views), [&](std::int64_t v) {
    CoveredMask& one = views[v];
    const int i = first.Find(one.view.name), k = last.Find(one.view.name);
    Camera& camera = one.view.camera;
    camera = camera.Scaled(std::min(1.0, kLongerSide / std::max(camera.width, camera.height)));
    one.mask = BothMasks(first.MaskPath(i), last.MaskPath(k), camera);
    if (camera.distorted()) one.mask = Undistorted(one.mask, camera);
    camera = Pinhole(camera);
    one.covered = Covered(mesh, scene, one.view);
  });
  return views;
}

}  // namespace keypose::report
