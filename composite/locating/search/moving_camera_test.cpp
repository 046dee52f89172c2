// Frames of a camera that moves, by the look of a textured figure and by its outlines.
#include <gtest/gtest.h>

#include <numbers>

#include "composite/locating/search/locate_shot.h"
#include "core/geometry.h"
#include "core/ray_scene.h"
#include "core/render.h"
#include "core/rotations.h"
#include "core/testing_shapes.h"
#include "core/testing_spots.h"

namespace keypose::composite {
namespace {

constexpr int kSide = 480;

double TurnBetween(const Rigid3& a, const Rigid3& b) {
  return AngleOfDifference(RotationDifference(a.rotation, b.rotation)) * 180 / std::numbers::pi;
}

/// Filmed from around the figure, 20 degrees from above, with exact mattes.
struct Film {
  Mesh mesh;
  Image8 texture = Spots();
  std::vector<View> truth;
  ShotInput input;

  Film(const Mesh& filmed, const std::vector<double>& azimuths_deg) : mesh(filmed) {
    input.mesh = &mesh;
    input.poses = {mesh.points};
    input.focal_fixed = true, input.solve_k1 = false, input.still = false;
    for (const double azimuth : azimuths_deg) {
      truth.push_back(FitView(mesh.points, azimuth, 20, kSide, kSide));
      Add(truth.back());
    }
    input.camera = truth[0].camera;
  }

 private:
  void Add(const View& view) {
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
};

TEST(MovingCamera, IsNotFollowedToWhereOnlyOutlinesAgree) {
  Mesh ball = SpottedLump();
  ball.points = MakeIcosphere(4).points;  // the same outline from all sides
  Film film(ball, {20, 65});
  film.input.texture = &film.texture;
  const LocatedShot shot = LocateShot(film.input);
  for (int i = 0; i < 2; ++i)
    EXPECT_LT(TurnBetween(shot.frames[i].at.camera_from_mesh, film.truth[i].camera_from_world), 1)
        << "frame " << i;
}

TEST(MovingCamera, AllFramesAreAsExactAsThoseThatTheLensWasSolvedFrom) {
  std::vector<double> azimuths;
  for (int i = 0; i < 9; ++i) azimuths.push_back(12 * i);
  Film film(SpottedLump(), azimuths);
  film.input.texture = &film.texture;
  const LocatedShot shot = LocateShot(film.input);
  for (int i = 0; i < 9; ++i)
    EXPECT_LT(TurnBetween(shot.frames[i].at.camera_from_mesh, film.truth[i].camera_from_world), 0.2)
        << "frame " << i;
}

/// The matte with all that lies within `px` of it.
Image8 Grown(const Image8& matte, int px) {
  Image8 grown = matte;
  for (int y = px; y < matte.height - px; ++y)
    for (int x = px; x < matte.width - px; ++x)
      for (int v = -px; v <= px; ++v)
        for (int u = -px; u <= px; ++u)
          if (u * u + v * v <= px * px && *matte.at(x + u, y + v) > 127) *grown.at(x, y) = 255;
  return grown;
}

TEST(MovingCamera, MattesThatAreTooWideAllRoundDoNotChangeTheLens) {
  Film film(SpottedLump(), {0, 50, 100, 150, 200, 250});
  film.input.texture = &film.texture;
  const double focal = film.input.camera.fx;
  film.input.camera.fx = film.input.camera.fy = 1.02 * focal;
  film.input.focal_fixed = false, film.input.focal_deviation = 0.05;
  for (LocateFrame& frame : film.input.frames) frame.matte = Grown(frame.matte, 2);
  const LocatedShot shot = LocateShot(film.input);
  EXPECT_NEAR(shot.matte_offset_px, 2, 0.5);
  EXPECT_NEAR(shot.camera.fx / focal, 1, 0.005);
  EXPECT_LT(std::abs(std::log(shot.camera.fx / focal)), 2 * shot.focal_deviation);
}

}  // namespace
}  // namespace keypose::composite
