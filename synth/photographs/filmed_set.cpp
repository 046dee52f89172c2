#include "synth/photographs/filmed_set.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/numbers/parallel.h"
#include "core/pictures/render.h"
#include "core/pictures/srgb.h"
#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"
#include "synth/worlds/noise.h"

namespace keypose::synth {
namespace {

using Eigen::Vector3d;

constexpr int kShadowCells = 200;    // cells of the shadow's grid
constexpr double kShadowSide = 5.0;  // [m]
constexpr double kAmbientLight = 0.45, kLampLight = 0.55;
constexpr double kPixelNoise = 1.2;  // [grey levels]

std::uint8_t LevelOf(double level) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(level, 0.0, 255.0)));
}

Vector3d SetFloorColor(double x, double y) {
  const Vector3d p(x / 0.35, y / 0.35, 0.2);
  const double stain = 1 + 0.12 * FractalNoise(p, 3, 0.5, 41);
  const bool dark =
      (static_cast<int>(std::floor(x / 0.6)) + static_cast<int>(std::floor(y / 0.6))) & 1;
  return stain * (dark ? Vector3d(0.24, 0.26, 0.25) : Vector3d(0.31, 0.32, 0.30));
}

Vector3d SetWallColor(const Vector3d& direction) {
  const double up = std::clamp(0.5 + direction.z(), 0.0, 1.0);
  return (0.35 + 0.2 * up) * Vector3d(0.42, 0.47, 0.55) *
         (1 + 0.08 * GradientNoise(4 * direction, 43));
}

double PixelNoise(std::uint64_t seed, std::size_t i) {
  // two uniform numbers make a triangle, near enough to a normal distribution
  const std::uint64_t h = Hash(seed * 0x9e3779b9ULL + i);
  const double a = static_cast<double>(h & 0xffff) / 65536,
               b = static_cast<double>(h >> 16 & 0xffff) / 65536;
  return kPixelNoise * 2.45 * (a + b - 1);
}

}  // namespace

Vector3d FilmedSet::ToLamp() { return Vector3d(0.45, -0.35, 1).normalized(); }

FilmedSet::FilmedSet(std::vector<View> views) : views_(std::move(views)) {
  plates_.resize(views_.size());
  floors_.resize(views_.size());
  ParallelFor(SizeOf(views_), [&](std::int64_t v) {
    const View& view = views_[v];
    const Camera& camera = view.camera;
    plates_[v] = Image8(camera.width, camera.height, 3);
    floors_[v].resize(static_cast<std::size_t>(camera.width) * camera.height);
    const Vector3d eye = view.Center();
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x) {
        const Vector3d ray =
            view.camera_from_world.rotation.conjugate() * camera.Unproject({x + 0.5, y + 0.5});
        const double t =
            ray.z() < -1e-9 ? -eye.z() / ray.z() : std::numeric_limits<double>::infinity();
        const Vector3d hit = eye + t * ray;
        const bool floor = t < 1e3 && hit.head<2>().norm() < 7;
        const std::size_t i = static_cast<std::size_t>(y) * camera.width + x;
        floors_[v][i] =
            floor ? hit.head<2>().cast<float>().eval()
                  : Eigen::Vector2f::Constant(std::numeric_limits<float>::quiet_NaN()).eval();
        const Vector3d color =
            floor ? SetFloorColor(hit.x(), hit.y()) : SetWallColor(ray.normalized());
        for (int c = 0; c < 3; ++c)
          plates_[v].at(x, y)[c] =
              LevelOf(255 * SrgbFromLinear(std::min(1.0, color[c])) +
                      PixelNoise(static_cast<std::uint64_t>(v) + 77, 3 * i + c));
      }
  });
}

FilmedFrame::FilmedFrame(const FilmedSet& set, const Mesh& painted, const PointsX3& points)
    : set_(set), lit_(painted) {
  lit_.points = points;
  scene_ = std::make_unique<RayScene>(lit_.points, lit_.faces);
  const PointsX3 normals = VertexNormals(points, painted.faces);
  const Vector3d lamp = FilmedSet::ToLamp();
  for (Eigen::Index v = 0; v < points.rows(); ++v) {
    const Vector3d n = normals.row(v), origin = Vector3d(points.row(v)) + 0.004 * n;
    const double facing = n.dot(lamp);
    const bool lit = facing > 0 && !scene_->Occluded(origin, lamp, 0, 10);
    const double light = kAmbientLight * (0.75 + 0.25 * n.z()) + (lit ? kLampLight * facing : 0);
    for (int c = 0; c < 3; ++c)
      lit_.colors(v, c) =
          LevelOf(255 * SrgbFromLinear(
                            std::min(1.0, light * LinearFromSrgb(painted.colors(v, c) / 255.0))));
  }
  const Vector3d middle = points.colwise().mean();
  grid_low_ = middle.head<2>() - Eigen::Vector2d::Constant(kShadowSide / 2);
  shadow_.assign(static_cast<std::size_t>(kShadowCells) * kShadowCells, 1);
  // The lamp has a size: its shadow has soft edges.
  const Vector3d across = lamp.unitOrthogonal(), other = lamp.cross(across);
  const std::array<Eigen::Vector2d, 5> spots{
      {{0, 0}, {.02, .01}, {-.01, .02}, {-.02, -.01}, {.01, -.02}}};
  for (int y = 0; y < kShadowCells; ++y)
    for (int x = 0; x < kShadowCells; ++x) {
      const Vector3d origin(grid_low_.x() + (x + 0.5) * kShadowSide / kShadowCells,
                            grid_low_.y() + (y + 0.5) * kShadowSide / kShadowCells, 0.002);
      int open = 0;
      for (const Eigen::Vector2d& spot : spots)
        open += !scene_->Occluded(origin, lamp + spot.x() * across + spot.y() * other, 0, 10);
      shadow_[static_cast<std::size_t>(y) * kShadowCells + x] =
          static_cast<float>(open) / SizeOf(spots);
    }
}

double FilmedFrame::ShadowAt(const Eigen::Vector2f& floor) const {
  const Eigen::Vector2d at = (floor.cast<double>() - grid_low_) * (kShadowCells / kShadowSide) -
                             Eigen::Vector2d::Constant(0.5);
  if (!(at.x() >= 0 && at.y() >= 0 && at.x() < kShadowCells - 1 && at.y() < kShadowCells - 1))
    return 1;
  const int x = static_cast<int>(at.x()), y = static_cast<int>(at.y());
  const double u = at.x() - x, v = at.y() - y;
  const float* s = shadow_.data() + static_cast<std::size_t>(y) * kShadowCells + x;
  return (1 - v) * ((1 - u) * s[0] + u * s[1]) +
         v * ((1 - u) * s[kShadowCells] + u * s[kShadowCells + 1]);
}

Image8 FilmedFrame::Picture(int view, std::uint64_t noise_seed) const {
  RenderOptions options;
  options.shading = 0;
  options.samples = 2;
  const Image8 actor = RenderCutout(lit_, *scene_, set_.views()[view], options);
  Image8 picture = set_.Plate(view);
  const std::vector<Eigen::Vector2f>& floor = set_.Floor(view);
  for (std::size_t i = 0; i < floor.size(); ++i) {
    const double alpha = actor.data[4 * i + 3] / 255.0;
    const double shadow = std::isnan(floor[i].x()) ? 1 : ShadowAt(floor[i]);
    for (int c = 0; c < 3; ++c) {
      double level = picture.data[3 * i + c];
      if (shadow < 1)
        level = 255 *
                SrgbFromLinear((kAmbientLight + kLampLight * shadow) * LinearFromSrgb(level / 255));
      level = alpha * actor.data[4 * i + c] + (1 - alpha) * level;
      picture.data[3 * i + c] = LevelOf(level + PixelNoise(noise_seed, 3 * i + c));
    }
  }
  return picture;
}

}  // namespace keypose::synth
