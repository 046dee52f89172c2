#include "fit/testing/spotted_lump.h"

#include "core/pictures/render.h"

namespace keypose::fit {
namespace {

constexpr int kSide = 420;

}  // namespace

std::vector<View> RingAround(const Mesh& mesh, const std::vector<double>& azimuths_deg) {
  std::vector<View> ring;
  for (const double azimuth : azimuths_deg)
    ring.push_back(keypose::FitView(mesh.points, azimuth, 20, kSide, kSide));
  return ring;
}

PreparedView PhotographOf(const Mesh& mesh, const Image8& texture, const View& view) {
  RenderOptions options;
  options.texture = &texture;
  options.shading = 0;
  const RayScene scene(mesh.points, mesh.faces);
  const Image8 cutout = RenderCutout(mesh, scene, view, options);
  Image8 mask(kSide, kSide, 1);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) *mask.at(x, y) = cutout.at(x, y)[3] > 127 ? 255 : 0;
  return PrepareView(view, 0, Render(mesh, scene, view, options), mask, 1, 3);
}

}  // namespace keypose::fit
