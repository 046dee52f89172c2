#include "synth/photographs/photographer.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/pictures/pixel_rays.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "synth/photographs/board_picture.h"
#include "synth/photographs/enlarged.h"
#include "synth/photographs/light.h"
#include "synth/photographs/ring_views.h"
#include "synth/photographs/sensor.h"
#include "synth/worlds/hand.h"
#include "synth/worlds/posed_clay.h"

namespace keypose::synth {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kTableHalfWidth = 0.24;  // [m]

/// The pixels that the character may cover, [x0, x1) x [y0, y1).
struct Window {
  int x0, y0, x1, y1;
  bool Has(int x, int y) const { return x >= x0 && x < x1 && y >= y0 && y < y1; }
};

Window WindowOf(const View& view, const PointsX3& points) {
  double low[2] = {1e9, 1e9}, high[2] = {-1e9, -1e9};
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Vector2d pixel = view.Project(points.row(i));
    for (int k = 0; k < 2; ++k) {
      low[k] = std::min(low[k], pixel[k]);
      high[k] = std::max(high[k], pixel[k]);
    }
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

/// The photographs as they are drawn, before they are enlarged.
PhotographerOptions Drawn(PhotographerOptions options) {
  options.width /= options.enlarge;
  options.height /= options.enlarge;
  return options;
}

}  // namespace

struct Photographer::Impl {
  Impl(const World& the_world, const Pose& pose, const PhotographerOptions& the_options,
       const std::vector<RingView>* stands)
      : options(the_options),
        clay(the_world, pose),
        views(stands ? *stands : PlaceCameras(clay.surface.points, options)),
        rays(views.front().view.camera.Scaled(1.0 / options.enlarge)),
        backdrop(Backdrop(Drawn(options))),
        light(clay.surface, clay.normals, clay.scene, UprightLamp(options).elevation_rad),
        table(clay.scene, kTableHalfWidth) {
    if (options.board.charuco) board = MakeBoardPicture(options.board);
    if (options.mishaps.lamp_falls_after < 1)
      fallen_light.emplace(clay.surface, clay.normals, clay.scene,
                           FallenLamp(options).elevation_rad);
    hands = HandViews(options.mishaps, SizeOf(views));
  }
  bool LampLies(int i) const {
    return i >= FirstAfter(options.mishaps.lamp_falls_after, SizeOf(views));
  }

  PhotographerOptions options;
  PosedClay clay;
  std::vector<RingView> views;
  PixelRays rays;
  ImageF backdrop;
  LightField light;
  std::optional<LightField> fallen_light;  // after the lamp fell
  TableLight table;
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
      : options_(set.options),
        clay_(set.clay),
        view_(ring_view.view),
        rays_(set.rays),
        backdrop_(set.backdrop),
        table_(set.table),
        board_(set.board ? &*set.board : nullptr),
        lamp_direction_(
            LampDirection(ring_view.azimuth_rad + stand.aside_rad, stand.elevation_rad)),
        upright_height_(std::sin(UprightLamp(set.options).elevation_rad)),
        table_from_world_(ring_view.table_from_world),
        world_from_camera_(ring_view.view.camera_from_world.Inverse()),
        turn_(world_from_camera_.rotation.toRotationMatrix()),
        window_(WindowOf(view_, clay_.surface.points)) {
    const double lamp_azimuth = ring_view.azimuth_rad + stand.aside_rad;
    if (options_.shadows) {
      lamp_ = field.Lamp(lamp_azimuth);
      table_lamp_ = table_.Lamp(lamp_azimuth, stand.elevation_rad);
    } else {
      lamp_.assign(clay_.lumps.size(), 1.0f);
    }
    light_ = {&lamp_,           options_.shadows ? &field.sky() : nullptr,
              lamp_direction_,  options_.lamp,
              options_.ambient, options_.gloss};
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
          const RayScene::Hit hit = clay_.scene.Cast(world_from_camera_.translation, direction);
          if (hit.face < 0) continue;
          sum += clay_.Shade(hit, direction.normalized(), light_);
          ++hits;
        }
    }
    *covered = static_cast<double>(hits) / (n * n);
    if (hits == n * n) return sum / hits;
    return sum / (n * n) + (1 - *covered) * Behind(x, y);
  }

 private:
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

  const PhotographerOptions& options_;
  const PosedClay& clay_;
  const View& view_;
  const PixelRays& rays_;
  const ImageF& backdrop_;
  const TableLight& table_;
  const BoardPicture* board_;
  Vector3d lamp_direction_;
  double upright_height_;  // height (z) of the unit vector to the standing lamp
  Rigid3 table_from_world_;
  Rigid3 world_from_camera_;
  Eigen::Matrix3d turn_;
  Window window_;
  std::vector<float> lamp_, table_lamp_;
  ClayLight light_;
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
const Mesh& Photographer::surface() const { return impl_->clay.surface; }

SyntheticView Photographer::Take(int i) const {
  const int enlarge = impl_->options.enlarge;
  RingView drawn = impl_->views[i];
  drawn.view.camera = drawn.view.camera.Scaled(1.0 / enlarge);
  const bool lies = impl_->LampLies(i);
  const Exposure exposure(*impl_, drawn, lies ? *impl_->fallen_light : impl_->light,
                          lies ? FallenLamp(impl_->options) : UprightLamp(impl_->options));
  const int width = drawn.view.camera.width, height = drawn.view.camera.height;
  ImageF linear(width, height, 3), share(width, height, 1);
  const auto row = [&](std::int64_t y) {
    for (int x = 0; x < width; ++x) {
      double covered = 0;
      const Vector3d color = exposure.Pixel(x, static_cast<int>(y), &covered);
      for (int c = 0; c < 3; ++c)
        linear.at(x, static_cast<int>(y))[c] = static_cast<float>(color[c]);
      *share.at(x, static_cast<int>(y)) = static_cast<float>(covered);
    }
  };
  ParallelFor(height, row, 16);
  linear = Enlarged(std::move(linear), enlarge);
  share = Enlarged(std::move(share), enlarge);
  SyntheticView photograph{impl_->views[i].view, {}, Image8(share.width, share.height, 1)};
  for (std::size_t p = 0; p < share.data.size(); ++p)
    photograph.mask.data[p] = share.data[p] >= 0.5f ? 255 : 0;
  if (std::binary_search(impl_->hands.begin(), impl_->hands.end(), i))
    HoldHand(linear, photograph.mask, impl_->options.seed * 977 + static_cast<std::uint64_t>(i));
  photograph.image =
      Develop(std::move(linear), SensorFor(impl_->options, static_cast<std::uint64_t>(i) + 1));
  return photograph;
}

Image8 Photographer::CleanPlate() const {
  return Develop(Enlarged(impl_->backdrop, impl_->options.enlarge), SensorFor(impl_->options, 0));
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
