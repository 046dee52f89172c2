#include "report/shots_stage.h"

#include <algorithm>
#include <cmath>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/numbers/parallel.h"

namespace keypose::report {
namespace {

Image8 BothMasks(const Image8& first, const Image8& last, const Camera& size) {
  Image8 both = Resized(first, size.width, size.height);
  const Image8 other = Resized(last, size.width, size.height);
  for (std::size_t i = 0; i < both.data.size(); ++i)
    both.data[i] = std::min(both.data[i], other.data[i]);
  return both;
}

}  // namespace

Shot Shrunk(const Shot& shot, double factor) {
  if (factor >= 1) return shot;
  Shot small = shot;
  small.view.camera = shot.view.camera.Scaled(factor);
  small.view.camera.width =
      std::max(1, static_cast<int>(std::lround(shot.photograph.width * factor)));
  small.view.camera.height =
      std::max(1, static_cast<int>(std::lround(shot.photograph.height * factor)));
  small.photograph = Resized(shot.photograph, small.view.camera.width, small.view.camera.height);
  small.mask = Resized(shot.mask, small.view.camera.width, small.view.camera.height);
  return small;
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
    one.mask = BothMasks(ReadImage(first.MaskPath(i), 1), ReadImage(last.MaskPath(k), 1), camera);
    one.covered = Covered(mesh, scene, one.view);
  });
  return views;
}

}  // namespace keypose::report
