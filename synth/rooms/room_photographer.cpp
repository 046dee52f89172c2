#include "synth/rooms/room_photographer.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/pictures/fit_view.h"
#include "core/pictures/pixel_rays.h"
#include "core/values/size_of.h"
#include "synth/photographs/light.h"
#include "synth/photographs/sensor.h"
#include "synth/worlds/hand.h"

namespace keypose::synth {
namespace {

using Eigen::Vector3d;

constexpr int kEdgeSamples = 3, kClaySamples = 2;  // along each side of a pixel
constexpr int kNothing = -1, kClay = 1 << 24;      // what a ray meets; below kClay a piece
constexpr double kBlurPx = 0.55, kVignetting = 0.1;

/// What stands still, without the figure and its shadow.
struct StillLayer {
  ImageF light;
  Image8 parts;
};

/// The eye and its rays in one frame.
struct Eye {
  Eye(const View& view, const PixelRays& the_rays)
      : rays(the_rays),
        world_from_camera(view.camera_from_world.Inverse()),
        turn(world_from_camera.rotation.toRotationMatrix()),
        pixel_angle(1 / view.camera.fx) {}
  Vector3d Ray(int x, int y, double sx, double sy) const { return turn * rays.At(x, y, sx, sy); }
  const Vector3d& place() const { return world_from_camera.translation; }

  const PixelRays& rays;
  Rigid3 world_from_camera;
  Eigen::Matrix3d turn;
  double pixel_angle;  // of a pixel, at z = 1
};

/// Pixels whose neighbours show something else.
bool AtEdge(const ImageT<int>& seen, int x, int y) {
  const int here = *seen.at(x, y);
  for (int j = std::max(0, y - 1); j <= std::min(seen.height - 1, y + 1); ++j)
    for (int i = std::max(0, x - 1); i <= std::min(seen.width - 1, x + 1); ++i)
      if (*seen.at(i, j) != here) return true;
  return false;
}

template <class Sample>
Vector3d Averaged(int samples, const Sample& sample) {
  Vector3d sum = Vector3d::Zero();
  for (int j = 0; j < samples; ++j)
    for (int i = 0; i < samples; ++i) sum += sample((i + 0.5) / samples, (j + 0.5) / samples);
  return sum / (samples * samples);
}

void Put(ImageF& image, int x, int y, const Vector3d& light) {
  for (int c = 0; c < 3; ++c) image.at(x, y)[c] = static_cast<float>(light[c]);
}

StillLayer SeeStill(const RoomSet& set, const RoomPlan& plan, const View& view,
                    const PixelRays& rays) {
  const Eye eye(view, rays);
  const int width = view.camera.width, height = view.camera.height;
  StillLayer layer{ImageF(width, height, 3), Image8(width, height, 1)};
  ImageT<int> piece(width, height, 1, kNothing);
  const Vector3d to_lamp = plan.light.Direction();
  const auto light_of = [&](const RayScene::Hit& hit, const Vector3d& ray) -> Vector3d {
    if (hit.face < 0) return Vector3d::Constant(0.02);
    return set.room.Shade(hit, {ray, hit.distance * eye.pixel_angle, to_lamp}, plan.light);
  };
  ParallelFor(
      height,
      [&](std::int64_t row) {
        const int y = static_cast<int>(row);
        for (int x = 0; x < width; ++x) {
          const Vector3d ray = eye.Ray(x, y, 0.5, 0.5);
          const RayScene::Hit hit = set.room.scene().Cast(eye.place(), ray);
          Put(layer.light, x, y, light_of(hit, ray));
          if (hit.face < 0) continue;
          *piece.at(x, y) = set.room.PieceOf(hit.face);
          *layer.parts.at(x, y) = static_cast<std::uint8_t>(set.room.PartOf(hit.face));
        }
      },
      8);
  ParallelFor(
      height,
      [&](std::int64_t row) {
        const int y = static_cast<int>(row);
        for (int x = 0; x < width; ++x)
          if (AtEdge(piece, x, y))
            Put(layer.light, x, y, Averaged(kEdgeSamples, [&](double sx, double sy) {
                  const Vector3d ray = eye.Ray(x, y, sx, sy);
                  return light_of(set.room.scene().Cast(eye.place(), ray), ray);
                }));
      },
      8);
  return layer;
}

/// One photograph in the making: what moves with the figure, over what stands still.
class RoomExposure {
 public:
  RoomExposure(const RoomSet& set, const RoomPlan& plan, const RoomView& room_view,
               const PixelRays& rays, StillLayer still)
      : set_(set),
        plan_(plan),
        view_(room_view.OfFigure()),
        eye_(view_, rays),
        still_(std::move(still)),
        to_lamp_(
            LampDirection(plan.light.azimuth_rad - room_view.turn_rad, plan.light.elevation_rad)),
        table_lamp_(
            set.table->Lamp(plan.light.azimuth_rad - room_view.turn_rad, plan.light.elevation_rad)),
        room_from_figure_{
            Eigen::Quaterniond(Eigen::AngleAxisd(room_view.turn_rad, Vector3d::UnitZ())),
            Vector3d::Zero()} {
    for (const std::unique_ptr<ClayThing>& thing : set.clay)
      clay_lamp_.push_back(thing->light->Lamp(plan.light.azimuth_rad - room_view.turn_rad));
    for (std::size_t i = 0; i < set.clay.size(); ++i)
      clay_light_.push_back({&clay_lamp_[i], &set.clay[i]->light->sky(), to_lamp_, plan.light.lamp,
                             plan.light.ambient, plan.light.gloss});
  }

  RoomPhotograph Expose(ImageF* light) {
    const int width = view_.camera.width, height = view_.camera.height;
    RoomPhotograph photograph{{}, Image8(width, height, 1), std::move(still_.parts)};
    ShadeTable(photograph.parts);
    ImageT<int> seen(width, height, 1, kNothing);
    const PixelBox box = Window();
    Look(box, seen, photograph.parts);
    Refine(box, seen, photograph.mask);
    *light = std::move(still_.light);
    return photograph;
  }

 private:
  /// What a ray meets among all that moves with the figure.
  struct Met {
    int what = kNothing;
    RayScene::Hit hit;
  };

  PixelBox Window() const {
    PixelBox box = ProjectedBounds(set_.figure().surface.points, view_);
    const auto join = [&](const PointsX3& points) {
      const PixelBox other = ProjectedBounds(points, view_);
      box = {std::min(box.x0, other.x0), std::min(box.y0, other.y0), std::max(box.x1, other.x1),
             std::max(box.y1, other.y1)};
    };
    for (const std::unique_ptr<ClayThing>& thing : set_.clay) join(thing->clay.surface.points);
    if (!set_.close.empty()) join(set_.close.AsMesh().points);
    return box;
  }

  Met Meet(const Vector3d& ray) const {
    Met met;
    double nearest = std::numeric_limits<double>::infinity();
    if (!set_.close.empty()) {
      const RayScene::Hit hit = set_.close.scene().Cast(eye_.place(), ray);
      if (hit.face >= 0) {
        met = {set_.close.PieceOf(hit.face), hit};
        nearest = hit.distance;
      }
    }
    for (int i = 0; i < SizeOf(set_.clay); ++i) {
      const RayScene::Hit hit = set_.clay[i]->clay.scene.Cast(eye_.place(), ray, 0, nearest);
      if (hit.face >= 0) {
        met = {kClay + i, hit};
        nearest = hit.distance;
      }
    }
    if (met.what == kNothing || plan_.free_standing()) return met;
    // A carving is half in its wall.
    const bool hidden = set_.room.scene().Occluded(room_from_figure_ * eye_.place(),
                                                   room_from_figure_.rotation * ray, 0, nearest);
    return hidden ? Met{} : met;
  }

  Vector3d LightOf(const Met& met, const Vector3d& ray) const {
    if (met.what >= kClay)
      return set_.clay[met.what - kClay]->clay.Shade(met.hit, ray.normalized(),
                                                     clay_light_[met.what - kClay]);
    Furniture::Look look{ray, met.hit.distance * eye_.pixel_angle, to_lamp_};
    if (set_.close.IsGround(met.hit.face)) {
      const Vector3d p = eye_.place() + met.hit.distance * ray;
      look.lamp_share = set_.table->At(table_lamp_, p.x(), p.y());
      look.room_share = set_.table->At(set_.table->sky(), p.x(), p.y());
    }
    return set_.close.Shade(met.hit, look, plan_.light);
  }

  Part PartOf(const Met& met) const {
    return met.what >= kClay ? set_.clay[met.what - kClay]->part : set_.close.PartOf(met.hit.face);
  }

  /// The figure's shadow on the table, which lies a little below z = 0.
  void ShadeTable(const Image8& parts) {
    const double lit = plan_.light.lamp * to_lamp_.z(), whole = plan_.light.ambient + lit;
    ParallelFor(
        parts.height,
        [&](std::int64_t row) {
          const int y = static_cast<int>(row);
          for (int x = 0; x < parts.width; ++x) {
            if (*parts.at(x, y) != static_cast<std::uint8_t>(Part::kTable)) continue;
            const Vector3d ray = eye_.Ray(x, y, 0.5, 0.5);
            if (ray.z() >= 0) continue;
            const Vector3d p = eye_.place() + (set_.table_z - eye_.place().z()) / ray.z() * ray,
                           up = p - set_.table_z / to_lamp_.z() * to_lamp_;
            const double left =
                (plan_.light.ambient * set_.table->At(set_.table->sky(), p.x(), p.y()) +
                 lit * set_.table->At(table_lamp_, up.x(), up.y())) /
                whole;
            for (int c = 0; c < 3; ++c) still_.light.at(x, y)[c] *= static_cast<float>(left);
          }
        },
        8);
  }

  /// What each pixel's middle shows.
  void Look(const PixelBox& box, ImageT<int>& seen, Image8& parts) const {
    ParallelFor(
        box.y1 - box.y0,
        [&](std::int64_t row) {
          const int y = box.y0 + static_cast<int>(row);
          for (int x = box.x0; x < box.x1; ++x) {
            const Met met = Meet(eye_.Ray(x, y, 0.5, 0.5));
            *seen.at(x, y) = met.what;
            if (met.what != kNothing) *parts.at(x, y) = static_cast<std::uint8_t>(PartOf(met));
          }
        },
        8);
  }

  /// Light of the pixels: one ray where a print fills a pixel, more on clay and at edges.
  void Refine(const PixelBox& box, const ImageT<int>& seen, Image8& mask) {
    ParallelFor(
        box.y1 - box.y0,
        [&](std::int64_t row) {
          const int y = box.y0 + static_cast<int>(row);
          for (int x = box.x0; x < box.x1; ++x) {
            const bool edge = AtEdge(seen, x, y);
            const int what = *seen.at(x, y);
            if (!edge && what == kNothing) continue;
            const int samples = edge ? kEdgeSamples : (what >= kClay ? kClaySamples : 1);
            int of_figure = 0;
            const float* behind = still_.light.at(x, y);
            const Vector3d still(behind[0], behind[1], behind[2]);
            const Vector3d light = Averaged(samples, [&](double sx, double sy) {
              const Vector3d ray = eye_.Ray(x, y, sx, sy);
              const Met met = Meet(ray);
              of_figure += met.what == kClay;
              return met.what == kNothing ? still : LightOf(met, ray);
            });
            Put(still_.light, x, y, light);
            *mask.at(x, y) = 2 * of_figure >= samples * samples ? 255 : 0;
          }
        },
        8);
  }

  const RoomSet& set_;
  const RoomPlan& plan_;
  View view_;  // in the figure's frame, as all below
  Eye eye_;
  StillLayer still_;
  Vector3d to_lamp_;
  std::vector<float> table_lamp_;
  Rigid3 room_from_figure_;
  std::vector<std::vector<float>> clay_lamp_;
  std::vector<ClayLight> clay_light_;
};

SensorOptions SensorOf(const RoomPlan& plan, int photograph) {
  return {kBlurPx, kVignetting, plan.noise,
          plan.seed * 1000003 + static_cast<std::uint64_t>(photograph) + 1};
}

/// Marks what a hand has covered.
void MarkHand(const ImageF& before, const ImageF& after, Image8& parts) {
  for (std::size_t i = 0; i < parts.data.size(); ++i)
    if (!std::equal(&before.data[3 * i], &before.data[3 * i] + 3, &after.data[3 * i]))
      parts.data[i] = static_cast<std::uint8_t>(Part::kHand);
}

}  // namespace

struct RoomPhotographer::Impl {
  explicit Impl(const RoomPlan& the_plan)
      : plan(the_plan),
        set(BuildRoom(plan)),
        room_views(PlaceRoomViews(plan, set.figure().surface.points)) {
    for (const RoomView& room_view : room_views) {
      const auto key = KeyOf(room_view);
      if (!rays.count(key)) rays.emplace(key, PixelRays(room_view.view.camera));
      if (room_view.tripod >= 0 && !tripods.count(room_view.tripod))
        tripods.emplace(room_view.tripod, SeeStill(set, plan, room_view.view, rays.at(key)));
    }
  }
  static std::pair<int, int> KeyOf(const RoomView& room_view) {
    return {room_view.lens, room_view.view.camera.width};
  }

  RoomPlan plan;
  RoomSet set;
  std::vector<RoomView> room_views;
  std::map<std::pair<int, int>, PixelRays> rays;  // by lens and width
  std::map<int, StillLayer> tripods;
};

RoomPhotographer::RoomPhotographer(const RoomPlan& plan) : impl_(std::make_unique<Impl>(plan)) {}
RoomPhotographer::~RoomPhotographer() = default;
RoomPhotographer::RoomPhotographer(RoomPhotographer&&) noexcept = default;

const RoomPlan& RoomPhotographer::plan() const { return impl_->plan; }
const RoomSet& RoomPhotographer::set() const { return impl_->set; }
const std::vector<RoomView>& RoomPhotographer::room_views() const { return impl_->room_views; }

bool RoomPhotographer::HasHand(int i) const {
  const int count = SizeOf(impl_->room_views), hands = std::min(impl_->plan.hands, count);
  for (int k = 0; k < hands; ++k)
    if (i == (2 * k + 1) * count / (2 * hands)) return true;
  return false;
}

RoomPhotograph RoomPhotographer::Take(int i) const {
  const RoomView& room_view = impl_->room_views[i];
  const PixelRays& rays = impl_->rays.at(Impl::KeyOf(room_view));
  StillLayer still = room_view.tripod >= 0
                         ? impl_->tripods.at(room_view.tripod)
                         : SeeStill(impl_->set, impl_->plan, room_view.view, rays);
  ImageF light;
  RoomPhotograph photograph =
      RoomExposure(impl_->set, impl_->plan, room_view, rays, std::move(still)).Expose(&light);
  if (HasHand(i)) {
    const ImageF before = light;
    HoldHand(light, photograph.mask, impl_->plan.seed * 977 + static_cast<std::uint64_t>(i));
    MarkHand(before, light, photograph.parts);
  }
  for (float& value : light.data) value *= static_cast<float>(room_view.gain);
  photograph.image = Develop(std::move(light), SensorOf(impl_->plan, i));
  return photograph;
}

}  // namespace keypose::synth
