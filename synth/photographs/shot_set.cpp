#include "synth/photographs/shot_set.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/pictures/render.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "synth/photographs/light.h"
#include "synth/photographs/sensor.h"
#include "synth/worlds/noise.h"

namespace keypose::synth {
namespace {

using Eigen::Vector3d;

constexpr double kWall = 0.33;       // [m] y of the wall
constexpr double kTableGrid = 0.26;  // [m] half side of the shadow's grid
constexpr double kSetShadow = 0.75;  // share of the light that a full shadow takes
constexpr int kSamplesAlong = 3;     // rays per pixel along each axis
constexpr double kLampTop = 0.06;    // [rad] half the lamp's size
constexpr int kLampRays = 12, kShotSkyRays = 48;
constexpr double kFromSurface = 4e-4;  // [m]
constexpr double kGolden = 2.399963229728653;
const Vector3d kLampTint(1.02, 1.0, 0.95), kRoomTint(0.97, 1.0, 1.05);

double SmoothStep(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

/// A wooden table top: boards with a grain of their own.
Vector3d TableColor(double x, double y) {
  constexpr double kBoard = 0.055;
  const double board = std::floor(y / kBoard);
  const double shift = 17.3 * board;
  const double rings = FractalNoise({6 * x + shift, 90 * y, 0.3 * board}, 3, 0.55, 301);
  const double knots = GradientNoise({18 * x + shift, 30 * y, 0.7}, 302);
  const double gap = SmoothStep(std::abs(y / kBoard - board - 0.5) / 0.5 * 24 - 23);
  const double shade =
      (1 + 0.20 * rings + 0.12 * knots + 0.06 * std::fmod(shift, 1.7)) * (1 - 0.55 * gap);
  return shade * Vector3d(0.36, 0.235, 0.135);
}

/// Painted paper: a wash of colour, hills, and a few stars.
Vector3d WallColor(double x, double z) {
  const double wash = FractalNoise({7 * x, 7 * z, 0.1}, 4, 0.5, 311);
  Vector3d color = (1 + 0.18 * wash) * Vector3d(0.22, 0.30, 0.40);
  const double hill = 0.085 + 0.03 * std::sin(14 * x) + 0.02 * GradientNoise({9 * x, 0, 0}, 312);
  color += SmoothStep((hill - z) / 0.004) * (Vector3d(0.16, 0.25, 0.13) - color);
  for (int i = 0; i < 14; ++i) {
    const double sx = -0.5 + 1.0 * static_cast<double>(Hash(900 + i) % 1000) / 1000,
                 sz = 0.15 + 0.20 * static_cast<double>(Hash(950 + i) % 1000) / 1000;
    const double star = SmoothStep((0.006 - std::hypot(x - sx, z - sz)) / 0.002);
    color += star * (Vector3d(0.75, 0.66, 0.35) - color);
  }
  return color * (1 + 0.04 * GradientNoise({230 * x, 230 * z, 0.5}, 313));
}

/// Directions around +z weighted by the cosine, a spiral.
Vector3d SkyDirection(int i, int count) {
  const double r2 = (i + 0.5) / count, r = std::sqrt(r2), angle = kGolden * i;
  return {r * std::cos(angle), r * std::sin(angle), std::sqrt(1 - r2)};
}

/// Light that reaches each vertex: shares of the lamp and of the room.
struct VertexLight {
  std::vector<float> lamp, room;
};

VertexLight LightOn(const PointsX3& points, const PointsX3& normals, const RayScene& scene,
                    double azimuth, double elevation) {
  VertexLight light{std::vector<float>(static_cast<std::size_t>(points.rows())),
                    std::vector<float>(static_cast<std::size_t>(points.rows()))};
  const auto bake = [&](std::int64_t v) {
    const Vector3d normal = normals.row(v);
    const Vector3d from = Vector3d(points.row(v)) + kFromSurface * normal;
    double lamp = 0, room = 0;
    for (int i = 0; i < kLampRays; ++i) {
      const double r = kLampTop * std::sqrt((i + 0.5) / kLampRays), angle = kGolden * i;
      const Vector3d to = LampDirection(azimuth + r * std::cos(angle) / std::cos(elevation),
                                        elevation + r * std::sin(angle));
      lamp += normal.dot(to) > 0 && !scene.Occluded(from, to, 0, 1);
    }
    const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), normal);
    for (int i = 0; i < kShotSkyRays; ++i) {
      const Vector3d to = turn * SkyDirection(i, kShotSkyRays);
      if (!scene.Occluded(from, to, 0, 0.12)) room += to.z() < 0 ? 0.4 : 1;
    }
    light.lamp[v] = static_cast<float>(lamp / kLampRays);
    light.room[v] = static_cast<float>(room / kShotSkyRays);
  };
  ParallelFor(points.rows(), bake, 256);
  return light;
}

/// The character as one frame shows it.
struct Figure {
  Figure(const World& the_world, const PointsX3& the_points, const ShotSetOptions& the_options)
      : world(the_world),
        options(the_options),
        points(the_points),
        scene(points, world.rest.faces),
        normals(VertexNormals(points, world.rest.faces)),
        azimuth(the_options.lamp_azimuth_deg * kPi / 180),
        elevation(the_options.lamp_elevation_deg * kPi / 180),
        to_lamp(LampDirection(azimuth, elevation)),
        light(LightOn(points, normals, scene, azimuth, elevation)),
        table(scene, kTableGrid),
        table_lamp(table.Lamp(azimuth, elevation)) {}

  Vector3d Shade(const RayScene::Hit& hit, const Vector3d& ray) const {
    const auto corner = world.rest.faces.row(hit.face);
    const std::array<double, 3> w{1 - hit.u - hit.v, hit.u, hit.v};
    Vector3d rest = Vector3d::Zero(), normal = Vector3d::Zero();
    double lamp = 0, room = 0;
    for (int k = 0; k < 3; ++k) {
      rest += w[k] * world.rest.points.row(corner[k]).transpose();
      normal += w[k] * normals.row(corner[k]).transpose();
      lamp += w[k] * light.lamp[corner[k]];
      room += w[k] * light.room[corner[k]];
    }
    normal.normalize();
    const int lump = world.clay.LumpAt(rest);
    const Vector3d half = (to_lamp - ray.normalized()).normalized();
    const double shine = world.clay.lumps[lump].crisp ? 6 : 1;
    const double gloss =
        options.gloss * shine * lamp * std::pow(std::max(0.0, normal.dot(half)), 22 * shine);
    const Vector3d arrives = options.lamp * lamp * std::max(0.0, normal.dot(to_lamp)) * kLampTint +
                             options.ambient * room * kRoomTint;
    return world.clay.Paint(rest, lump).cwiseProduct(arrives) + gloss * kLampTint;
  }

  /// Share of the set's light that the character leaves on a point of the table.
  double OnTable(double x, double y) const {
    const double lit = options.lamp * to_lamp.z();
    const double left =
        (options.ambient * table.At(table.sky(), x, y) + lit * table.At(table_lamp, x, y)) /
        (options.ambient + lit);
    return 1 - kSetShadow * (1 - left);
  }

  const World& world;
  const ShotSetOptions& options;
  PointsX3 points;  // in the set's world
  RayScene scene;
  PointsX3 normals;
  double azimuth, elevation;
  Vector3d to_lamp;
  VertexLight light;
  TableLight table;
  std::vector<float> table_lamp;
};

Camera CameraOf(const ShotSetOptions& o) {
  Camera camera;
  camera.width = o.width;
  camera.height = o.height;
  camera.fx = camera.fy = o.focal_35mm / 36 * std::max(o.width, o.height);
  camera.cx = o.width / 2.0 + o.principal_shift_px;
  camera.cy = o.height / 2.0 - o.principal_shift_px;
  camera.k1 = o.k1;
  camera.k2 = o.k2;
  camera.p1 = o.p1;
  camera.p2 = o.p2;
  return camera;
}

const ShotSetOptions& Usable(const ShotSetOptions& options) {
  const std::vector<std::string> problems = options.Problems();
  if (!problems.empty()) throw UsageError("synth: " + problems.front());
  return options;
}

}  // namespace

std::vector<std::string> ShotSetOptions::Problems() const {
  std::vector<std::string> problems;
  if (width < 64 || height < 64 || width > 8192 || height > 8192)
    problems.push_back("the film's pictures must have from 64 to 8192 pixels a side");
  if (focal_35mm < 12 || focal_35mm > 300) problems.push_back("--focal must be from 12 to 300 mm");
  if (camera_elevation_deg < 2 || camera_elevation_deg > 60)
    problems.push_back("--camera-elevation must be from 2 to 60 degrees");
  if (grain < 0 || grain > 20) problems.push_back("--grain must be from 0 to 20");
  return problems;
}

ShotSet::ShotSet(const ShotSetOptions& options)
    : options_(Usable(options)), empty_(options.width, options.height, 3) {
  view_.name = "shot";
  view_.camera = CameraOf(options_);
  const double azimuth = options_.camera_azimuth_deg * kPi / 180,
               elevation = options_.camera_elevation_deg * kPi / 180;
  const Vector3d target(0, 0, 0.09);
  view_.camera_from_world =
      LookAt(target + options_.distance_m * LampDirection(azimuth, elevation), target);
  world_from_camera_ = view_.camera_from_world.Inverse();
  turn_ = world_from_camera_.rotation.toRotationMatrix();
  const int stride = options_.width + 1;
  corners_.resize(static_cast<std::size_t>(stride) * (options_.height + 1));
  ParallelFor(options_.height + 1, [&](std::int64_t y) {
    for (int x = 0; x < stride; ++x)
      corners_[y * stride + x] =
          view_.camera.Unproject(Eigen::Vector2d(x, static_cast<double>(y))).head<2>();
  });
  ParallelFor(options_.height, [&](std::int64_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < options_.width; ++x) {
      Vector3d sum = Vector3d::Zero();
      for (int i = 0; i < 4; ++i)
        sum += SetColor(Ray(x, y, 0.25 + 0.5 * (i & 1), i < 2 ? .25 : .75));
      for (int c = 0; c < 3; ++c) empty_.at(x, y)[c] = static_cast<float>(sum[c] / 4);
    }
  });
}

Vector3d ShotSet::Ray(int x, int y, double sx, double sy) const {
  const int stride = options_.width + 1;
  const Eigen::Vector2d* c = corners_.data() + static_cast<std::size_t>(y) * stride + x;
  const Eigen::Vector2d p =
      (1 - sy) * ((1 - sx) * c[0] + sx * c[1]) + sy * ((1 - sx) * c[stride] + sx * c[stride + 1]);
  return turn_ * Vector3d(p[0], p[1], 1);
}

Vector3d ShotSet::SetColor(const Vector3d& ray) const {
  const Vector3d& eye = world_from_camera_.translation;
  const double to_wall = ray.y() > 1e-9 ? (kWall - eye.y()) / ray.y() : 1e9,
               to_table = ray.z() < -1e-9 ? -eye.z() / ray.z() : 1e9;
  const Vector3d hit = eye + std::min(to_wall, to_table) * ray;
  if (to_table <= to_wall) {
    const double corner = 1 - 0.3 * SmoothStep((hit.y() - kWall + 0.05) / 0.05);
    return corner * TableColor(hit.x(), hit.y());
  }
  return WallColor(hit.x(), hit.z());
}

Image8 ShotSet::Developed(ImageF linear, std::uint64_t grain) const {
  return Develop(std::move(linear), {options_.blur_px, options_.vignetting, options_.grain,
                                     options_.seed * 1000033 + grain});
}

Image8 ShotSet::Plate(std::uint64_t grain) const { return Developed(empty_, 900001 + grain); }

ShotPicture ShotSet::Film(const World& world, const PointsX3& points,
                          const Similarity3& world_from_character, std::uint64_t grain) const {
  const Figure figure(world, Transformed(world_from_character, points), options_);
  const PixelBox box = ProjectedBounds(figure.points, view_);
  ImageF linear = empty_;
  ShotPicture shot{{}, Image8(options_.width, options_.height, 1)};
  const Vector3d& eye = world_from_camera_.translation;
  ParallelFor(options_.height, [&](std::int64_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < options_.width; ++x) {
      float* pixel = linear.at(x, y);
      const Vector3d middle = Ray(x, y, 0.5, 0.5);
      const double t = middle.z() < 0 ? -eye.z() / middle.z() : 1e9;
      const Vector3d on = eye + t * middle;
      const double left = on.y() < kWall ? figure.OnTable(on.x(), on.y()) : 1;
      for (int c = 0; c < 3; ++c) pixel[c] *= static_cast<float>(left);
      if (x < box.x0 || x >= box.x1 || y < box.y0 || y >= box.y1) continue;
      Vector3d sum = Vector3d::Zero();
      int hits = 0;
      for (int i = 0; i < kSamplesAlong * kSamplesAlong; ++i) {
        const Vector3d ray = Ray(x, y, (i % kSamplesAlong + 0.5) / kSamplesAlong,
                                 (i / kSamplesAlong + 0.5) / kSamplesAlong);
        const RayScene::Hit hit = figure.scene.Cast(eye, ray);
        if (hit.face >= 0) {
          sum += figure.Shade(hit, ray);
          ++hits;
        }
      }
      const double covered = hits / double{kSamplesAlong * kSamplesAlong};
      *shot.matte.at(x, y) = static_cast<std::uint8_t>(std::lround(255 * covered));
      for (int c = 0; c < 3; ++c)
        pixel[c] =
            static_cast<float>((1 - covered) * pixel[c] + sum[c] / (kSamplesAlong * kSamplesAlong));
    }
  });
  shot.picture = Developed(std::move(linear), grain);
  return shot;
}

}  // namespace keypose::synth
