#include "synth/photographer.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "core/angles.h"
#include "core/errors.h"
#include "core/geometry.h"
#include "core/parallel.h"
#include "core/ray_scene.h"
#include "core/size_of.h"
#include "synth/calibration_board.h"
#include "synth/hand.h"
#include "synth/light.h"
#include "synth/sensor.h"
#include "synth/turntable.h"

namespace keypose::synth {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kTableHalfWidth = 0.24;  // [m]
const Vector3d kLampColor(1.02, 1.0, 0.95), kRoomColor(0.97, 1.0, 1.05);
constexpr double kGlossPower = 22;

/// Points with z = 1 in the camera's frame, at the pixels' corners. Inside a pixel, bilinear
/// interpolation of the distortion is exact to 1e-6 px.
class RayTable {
 public:
  explicit RayTable(const Camera& camera)
      : stride_(camera.width + 1),
        corners_(static_cast<std::size_t>(stride_) * (camera.height + 1)) {
    const auto row = [&](std::int64_t y) {
      for (int x = 0; x < stride_; ++x)
        corners_[y * stride_ + x] = camera.Unproject(Vector2d(x, static_cast<double>(y))).head<2>();
    };
    ParallelFor(camera.height + 1, row, 16);
  }
  /// @param sx, sy  place inside the pixel, in [0,1]
  Vector3d At(int x, int y, double sx, double sy) const {
    const Vector2d* c = corners_.data() + static_cast<std::size_t>(y) * stride_ + x;
    const Vector2d p = (1 - sy) * ((1 - sx) * c[0] + sx * c[1]) +
                       sy * ((1 - sx) * c[stride_] + sx * c[stride_ + 1]);
    return {p[0], p[1], 1};
  }

 private:
  int stride_;
  std::vector<Vector2d> corners_;
};

/// The pixels that the character may cover, [x0, x1) x [y0, y1).
struct Window {
  int x0, y0, x1, y1;
  bool Has(int x, int y) const { return x >= x0 && x < x1 && y >= y0 && y < y1; }
};

Window WindowOf(const View& view, const PointsX3& points) {
  double low[2] = {1e9, 1e9}, high[2] = {-1e9, -1e9};
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Vector2d pixel = view.Project(points.row(i));
    for (int k = 0; k < 2; ++k)
      low[k] = std::min(low[k], pixel[k]), high[k] = std::max(high[k], pixel[k]);
  }
  const auto inside = [](double v, int size) {
    return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(size)));
  };
  return {inside(low[0] - 2, view.camera.width), inside(low[1] - 2, view.camera.height),
          inside(high[0] + 3, view.camera.width), inside(high[1] + 3, view.camera.height)};
}

/// Position of the lamp relative to the camera.
struct LampStand {
  double aside_rad, elevation_rad;
};

LampStand UprightLamp(const PhotographerOptions& options) {
  return {options.lamp_aside_rad, options.lamp_elevation_deg * kPi / 180};
}

LampStand FallenLamp(const PhotographerOptions& options) {
  return {options.mishaps.fallen_aside_rad, options.mishaps.fallen_elevation_deg * kPi / 180};
}

}  // namespace

struct Photographer::Impl {
  Impl(const World& the_world, const Pose& pose, const PhotographerOptions& the_options,
       const std::vector<RingView>* stands)
      : world(the_world),
        options(the_options),
        surface(TruthSurface(world, pose)),
        scene(surface.points, surface.faces),
        normals(VertexNormals(pose(world.smooth.rows() ? world.smooth : world.rest.points),
                              surface.faces)),  // the tilt of the prints is added at each point
        views(stands ? *stands : PlaceCameras(surface.points, options)),
        rays(views.front().view.camera),
        backdrop(Backdrop(options)),
        light(surface, normals, scene, UprightLamp(options).elevation_rad),
        table(scene, kTableHalfWidth),
        lumps(surface.points.rows()) {
    ParallelFor(
        world.rest.points.rows(),
        [&](std::int64_t i) { lumps[i] = world.clay.LumpAt(world.rest.points.row(i)); }, 512);
    if (options.board.charuco) board = MakeBoardPicture(options.board);
    if (options.mishaps.lamp_falls_after < 1)
      fallen_light.emplace(surface, normals, scene, FallenLamp(options).elevation_rad);
    hands = HandViews(options.mishaps, SizeOf(views));
  }
  bool LampLies(int i) const {
    return i >= FirstAfter(options.mishaps.lamp_falls_after, SizeOf(views));
  }

  World world;
  PhotographerOptions options;
  Mesh surface;
  RayScene scene;
  PointsX3 normals;
  std::vector<RingView> views;
  RayTable rays;
  ImageF backdrop;
  LightField light;
  std::optional<LightField> fallen_light;  // after the lamp fell
  TableLight table;
  std::vector<int> lumps;  // per vertex
  std::optional<BoardPicture> board;
  std::vector<int> hands;  // photographs with a hand
};

namespace {

/// The data of one photograph that all its pixels share.
class Exposure {
 public:
  template <class Impl>
  Exposure(const Impl& set, const RingView& ring_view, const LightField& field,
           const LampStand& stand)
      : world_(set.world),
        options_(set.options),
        surface_(set.surface),
        scene_(set.scene),
        normals_(set.normals),
        view_(ring_view.view),
        rays_(set.rays),
        backdrop_(set.backdrop),
        sky_(field.sky()),
        table_(set.table),
        lumps_(set.lumps),
        board_(set.board ? &*set.board : nullptr),
        lamp_direction_(
            LampDirection(ring_view.azimuth_rad + stand.aside_rad, stand.elevation_rad)),
        upright_height_(std::sin(UprightLamp(set.options).elevation_rad)),
        table_from_world_(ring_view.table_from_world),
        world_from_camera_(ring_view.view.camera_from_world.Inverse()),
        turn_(world_from_camera_.rotation.toRotationMatrix()),
        window_(WindowOf(view_, surface_.points)) {
    const double lamp_azimuth = ring_view.azimuth_rad + stand.aside_rad;
    if (options_.shadows) {
      lamp_ = field.Lamp(lamp_azimuth);
      table_lamp_ = table_.Lamp(lamp_azimuth, stand.elevation_rad);
    } else {
      lamp_.assign(lumps_.size(), 1.0f);
    }
  }

  /// Light of one pixel; `covered` receives the share of the pixel that the character covers.
  Vector3d Pixel(int x, int y, double* covered) const {
    const int n = options_.supersampling;
    Vector3d sum = Vector3d::Zero();
    int hits = 0;
    if (window_.Has(x, y)) {
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
          const Vector3d direction = turn_ * rays_.At(x, y, (i + 0.5) / n, (j + 0.5) / n);
          const RayScene::Hit hit = scene_.Cast(world_from_camera_.translation, direction);
          if (hit.face < 0) continue;
          sum += Shade(hit, direction.normalized());
          ++hits;
        }
    }
    *covered = static_cast<double>(hits) / (n * n);
    if (hits == n * n) return sum / hits;
    return sum / (n * n) + (1 - *covered) * Behind(x, y);
  }

 private:
  Vector3d Shade(const RayScene::Hit& hit, const Vector3d& direction) const {
    const int a = surface_.faces(hit.face, 0), b = surface_.faces(hit.face, 1),
              c = surface_.faces(hit.face, 2);
    const double w = 1 - hit.u - hit.v;
    const auto mix = [&](const PointsX3& rows) -> Vector3d {
      return (w * rows.row(a) + hit.u * rows.row(b) + hit.v * rows.row(c)).transpose();
    };
    const auto mix_light = [&](const std::vector<float>& values) {
      return w * values[a] + hit.u * values[b] + hit.v * values[c];
    };
    const Vector3d rest = mix(world_.rest.points);
    const int lump =
        lumps_[a] == lumps_[b] && lumps_[b] == lumps_[c] ? lumps_[a] : world_.clay.LumpAt(rest);
    const Vector3d normal =
        (mix(normals_).normalized() - PosedSlope(world_.clay.RidgeSlope(rest, lump), a, b, c))
            .normalized();
    const double lamp = options_.lamp * mix_light(lamp_),
                 facing = std::max(0.0, normal.dot(lamp_direction_));
    const double room = options_.ambient * (options_.shadows ? mix_light(sky_) : 1);
    const Vector3d light = lamp * facing * kLampColor + room * kRoomColor;
    const Vector3d halfway = (lamp_direction_ - direction).normalized();
    const double shine = world_.clay.lumps[lump].crisp ? 6 : 1;
    const double gloss = options_.gloss * shine * mix_light(lamp_) *
                         std::pow(std::max(0.0, normal.dot(halfway)), kGlossPower * shine);
    return world_.clay.Paint(rest, lump).cwiseProduct(light) + gloss * kLampColor;
  }

  /// Transfers a slope from the rest triangle to the posed one: the rise along corresponding edges
  /// is equal.
  Vector3d PosedSlope(const Vector3d& slope, int a, int b, int c) const {
    if (slope.isZero(0)) return slope;
    const auto edges = [&](const PointsX3& p) {
      Eigen::Matrix<double, 3, 2> e;
      e.col(0) = (p.row(b) - p.row(a)).transpose();
      e.col(1) = (p.row(c) - p.row(a)).transpose();
      return e;
    };
    const Eigen::Matrix<double, 3, 2> rest = edges(world_.rest.points),
                                      posed = edges(surface_.points);
    const Eigen::Matrix2d metric = posed.transpose() * posed;
    return posed * metric.inverse() * (rest.transpose() * slope);
  }

  /// The set behind the character: backdrop, shadow on the table, board.
  Vector3d Behind(int x, int y) const {
    const float* back = backdrop_.at(x, y);
    Vector3d color = BackdropLight() * Vector3d(back[0], back[1], back[2]);
    const Vector3d direction = turn_ * rays_.At(x, y, 0.5, 0.5),
                   eye = world_from_camera_.translation;
    if (direction[2] >= 0) return color;
    const Vector3d p = eye + direction * (eye[2] / -direction[2]);
    const double open = options_.ambient + options_.lamp * lamp_direction_[2];
    double share = 1;
    if (options_.shadows) {
      const double lamp = table_.At(table_lamp_, p[0], p[1]),
                   room = table_.At(table_.sky(), p[0], p[1]);
      const double darkened =
          (options_.ambient * room + options_.lamp * lamp_direction_[2] * lamp) / open;
      share = 1 - options_.table_shadow * (1 - darkened);
    }
    if (board_ && OnBoard(p)) color = open * BoardAt(x, y);
    return share * color;
  }

  /// A low lamp gives the set less light.
  double BackdropLight() const {
    const double now = options_.ambient + options_.lamp * lamp_direction_[2];
    return now / (options_.ambient + options_.lamp * upright_height_);
  }

  bool OnBoard(const Vector3d& x_in_world) const {
    const Vector3d p = table_from_world_ * x_in_world;
    return std::abs(p[0]) < board_->width_m / 2 && std::abs(p[1]) < board_->height_m / 2;
  }

  /// Paper and ink of the board in one pixel.
  Vector3d BoardAt(int x, int y) const {
    const Vector3d eye = world_from_camera_.translation;
    constexpr int kSamples = 3;
    double sum = 0;
    for (int j = 0; j < kSamples; ++j)
      for (int i = 0; i < kSamples; ++i) {
        const Vector3d d = turn_ * rays_.At(x, y, (i + 0.5) / kSamples, (j + 0.5) / kSamples);
        const Vector3d p = table_from_world_ * (eye + d * (eye[2] / -d[2]));
        const int px = static_cast<int>((p[0] / board_->width_m + 0.5) * board_->picture.width);
        const int py = static_cast<int>((0.5 - p[1] / board_->height_m) * board_->picture.height);
        const bool on =
            px >= 0 && py >= 0 && px < board_->picture.width && py < board_->picture.height;
        sum += !on || *board_->picture.at(px, py) > 127 ? 0.80 : 0.035;
      }
    return Vector3d::Constant(sum / (kSamples * kSamples));
  }

  const World& world_;
  const PhotographerOptions& options_;
  const Mesh& surface_;
  const RayScene& scene_;
  const PointsX3& normals_;
  const View& view_;
  const RayTable& rays_;
  const ImageF& backdrop_;
  const std::vector<float>& sky_;
  const TableLight& table_;
  const std::vector<int>& lumps_;
  const BoardPicture* board_;
  Vector3d lamp_direction_;
  double upright_height_;  // height (z) of the unit vector to the standing lamp
  Rigid3 table_from_world_;
  Rigid3 world_from_camera_;
  Eigen::Matrix3d turn_;
  Window window_;
  std::vector<float> lamp_, table_lamp_;
};

SensorOptions SensorFor(const PhotographerOptions& options, std::uint64_t photograph) {
  return {options.blur_px, options.vignetting, options.noise, options.seed * 1000003 + photograph};
}

const PhotographerOptions& Checked(const PhotographerOptions& options) {
  const std::vector<std::string> problems = options.Problems();
  if (!problems.empty()) throw UsageError("synth: " + problems.front());
  return options;
}

}  // namespace

Photographer::Photographer(const World& world, const Pose& pose, const PhotographerOptions& options,
                           const Photographer* rig)
    : impl_(std::make_unique<Impl>(world, pose, Checked(options),
                                   rig ? &rig->impl_->views : nullptr)) {}
Photographer::~Photographer() = default;
Photographer::Photographer(Photographer&&) noexcept = default;

int Photographer::view_count() const { return SizeOf(impl_->views); }
const View& Photographer::ViewAt(int i) const { return impl_->views[i].view; }
const Mesh& Photographer::surface() const { return impl_->surface; }

SyntheticView Photographer::Take(int i) const {
  const RingView& ring_view = impl_->views[i];
  const bool lies = impl_->LampLies(i);
  const Exposure exposure(*impl_, ring_view, lies ? *impl_->fallen_light : impl_->light,
                          lies ? FallenLamp(impl_->options) : UprightLamp(impl_->options));
  const int width = impl_->options.width, height = impl_->options.height;
  SyntheticView photograph{ring_view.view, {}, Image8(width, height, 1)};
  ImageF linear(width, height, 3);
  const auto row = [&](std::int64_t y) {
    for (int x = 0; x < width; ++x) {
      double covered = 0;
      const Vector3d color = exposure.Pixel(x, static_cast<int>(y), &covered);
      for (int c = 0; c < 3; ++c)
        linear.at(x, static_cast<int>(y))[c] = static_cast<float>(color[c]);
      *photograph.mask.at(x, static_cast<int>(y)) = covered >= 0.5 ? 255 : 0;
    }
  };
  ParallelFor(height, row, 16);
  if (std::binary_search(impl_->hands.begin(), impl_->hands.end(), i))
    HoldHand(linear, photograph.mask, impl_->options.seed * 977 + static_cast<std::uint64_t>(i));
  photograph.image =
      Develop(std::move(linear), SensorFor(impl_->options, static_cast<std::uint64_t>(i) + 1));
  return photograph;
}

Image8 Photographer::CleanPlate() const {
  return Develop(impl_->backdrop, SensorFor(impl_->options, 0));
}

std::vector<SyntheticView> Photograph(const World& world, const Pose& pose,
                                      const PhotographerOptions& options, Progress* progress) {
  const Photographer photographer(world, pose, options);
  std::vector<SyntheticView> photographs;
  for (int i = 0; i < photographer.view_count(); ++i) {
    ReportProgress(progress, static_cast<double>(i) / photographer.view_count(), "photographs");
    photographs.push_back(photographer.Take(i));
  }
  return photographs;
}

Scene TruthScene(const World& world, const Pose& pose,
                 const std::vector<SyntheticView>& photographs, int points) {
  const Mesh surface = TruthSurface(world, pose, true);
  const PointsX3 normals = VertexNormals(surface.points, surface.faces);
  const RayScene rays(surface.points, surface.faces);
  Scene scene;
  for (const SyntheticView& photograph : photographs) scene.views.push_back(photograph.view);
  const int stride = std::max(1, surface.vertex_count() / std::max(1, points));
  std::vector<SparsePoint> found(
      static_cast<std::size_t>((surface.vertex_count() + stride - 1) / stride));
  const auto look = [&](std::int64_t i) {
    const Vector3d x = surface.points.row(i * stride), normal = normals.row(i * stride);
    SparsePoint& point = found[i];
    point.position = x;
    point.color = surface.colors.row(i * stride).transpose();
    for (std::size_t v = 0; v < scene.views.size(); ++v) {
      const Vector3d to_camera = scene.views[v].Center() - x;
      if (normal.dot(to_camera.normalized()) < 0.2 ||
          rays.Occluded(x + 2e-4 * normal, to_camera, 0, 1))
        continue;
      const Vector2d pixel = scene.views[v].Project(x);
      const Camera& camera = scene.views[v].camera;
      if (pixel[0] >= 0 && pixel[1] >= 0 && pixel[0] < camera.width && pixel[1] < camera.height)
        point.views.push_back(static_cast<int>(v));
    }
  };
  ParallelFor(std::ssize(found), look, 64);
  for (SparsePoint& point : found)
    if (point.views.size() >= 2) scene.points.push_back(std::move(point));
  return scene;
}

}  // namespace keypose::synth
