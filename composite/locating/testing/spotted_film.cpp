#include "composite/locating/testing/spotted_film.h"

#include "core/pictures/fit_view.h"
#include "core/pictures/render.h"
#include "core/surfaces/ray_scene.h"

namespace keypose::composite {
namespace {

constexpr int kSide = 480;

}  // namespace

SpottedFilm::SpottedFilm(const Mesh& filmed, const Image8& painted,
                         const std::vector<double>& azimuths_deg)
    : mesh(filmed), texture(painted) {
  input.mesh = &mesh;
  input.poses = {mesh.points};
  input.focal_fixed = true, input.solve_k1 = false, input.still = false;
  for (const double azimuth : azimuths_deg) {
    truth.push_back(FitView(mesh.points, azimuth, 20, kSide, kSide));
    Add(truth.back());
  }
  input.camera = truth[0].camera;
}

void SpottedFilm::Add(const View& view) {
  RenderOptions options;
  options.texture = &texture;
  options.shading = 0;
  const RayScene scene(mesh.points, mesh.faces);
  const Image8 cutout = RenderCutout(mesh, scene, view, options);
  LocateFrame frame;
  frame.name = std::to_string(input.frames.size());
  frame.time = static_cast<double>(input.frames.size());
  frame.picture = Render(mesh, scene, view, options);
  frame.matte = Image8(kSide, kSide, 1);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) *frame.matte.at(x, y) = cutout.at(x, y)[3] > 127 ? 255 : 0;
  input.frames.push_back(std::move(frame));
}

}  // namespace keypose::composite
