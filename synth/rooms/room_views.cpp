#include "synth/rooms/room_views.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/pictures/fit_view.h"
#include "core/values/angles.h"
#include "core/values/size_of.h"
#include "synth/worlds/noise.h"

namespace keypose::synth {
namespace {

using Eigen::Vector3d;

/// A place of the camera: a direction from the figure, and how large the figure is in the picture.
struct Aim {
  double azimuth = 0, elevation = 0.4;  // [rad]
  double fill = 0.6;                    // share of the picture's height that the figure has
  double height = 0.5;                  // what the camera looks at, of the figure's height
  double aside = 0;                     // of the figure's height, to the right
  double roll = 0;                      // [rad]
};

class Placing {
 public:
  Placing(const RoomPlan& plan, const PointsX3& figure)
      : plan_(plan), random_(plan.seed * 9176 + 31) {
    height_ = figure.col(2).maxCoeff();
    radius_ = figure.leftCols<2>().rowwise().norm().maxCoeff();
    for (int lens = 0; lens < 2; ++lens) lenses_[lens] = MakeLens(plan.focal_35mm[lens]);
  }

  std::vector<RoomView> All() {
    switch (plan_.kind) {
      case RoomKind::kWalk:
        Walk(plan_.photographs);
        break;
      case RoomKind::kOneSide:
        Arc(plan_.photographs, random_.Uniform(50, 65));
        break;
      case RoomKind::kTrunk:
        Arc(plan_.photographs, random_.Uniform(55, 75));
        break;
      case RoomKind::kRelief:
        Arc(plan_.photographs, random_.Uniform(45, 60));
        break;
      case RoomKind::kBoth:
        Both();
        break;
      default:
        Rings(plan_.photographs, false);
    }
    for (int i = 0; i < SizeOf(room_views_); ++i) {
      char name[32];
      std::snprintf(name, sizeof name, "IMG_%04d.jpg", i + 1);
      room_views_[i].view.name = name;
    }
    return std::move(room_views_);
  }

 private:
  Camera MakeLens(double focal_35mm) {
    Camera camera;
    camera.width = plan_.width;
    camera.height = plan_.height;
    const double size = std::max(plan_.width, plan_.height);
    camera.fx = camera.fy = focal_35mm / 36 * size;
    camera.cx = plan_.width / 2.0 + size * random_.Uniform(-0.006, 0.006);
    camera.cy = plan_.height / 2.0 + size * random_.Uniform(-0.006, 0.006);
    camera.k1 = random_.Uniform(-0.09, 0.04);
    camera.k2 = random_.Uniform(-0.02, 0.03);
    camera.p1 = random_.Uniform(-4e-4, 4e-4);
    camera.p2 = random_.Uniform(-4e-4, 4e-4);
    return camera;
  }

  double Jitter(double by) { return random_.Uniform(-by, by); }

  /// Distance at which the figure fills the wanted share, and its width has room.
  double Distance(const Camera& camera, double fill) const {
    const double by_height = camera.fy * height_ / (fill * camera.height),
                 by_width = camera.fx * 2 * radius_ / (1.55 * fill * camera.width);
    return std::max(by_height, by_width) + 0.4 * radius_;
  }

  void Take(const Aim& aim, RoomView room_view, bool portrait) {
    room_view.view.camera =
        portrait ? TurnedClockwise(lenses_[room_view.lens]) : lenses_[room_view.lens];
    const double distance = Distance(room_view.view.camera, aim.fill);
    const Vector3d out(std::cos(aim.elevation) * std::cos(aim.azimuth),
                       std::cos(aim.elevation) * std::sin(aim.azimuth), std::sin(aim.elevation)),
        right(-std::sin(aim.azimuth), std::cos(aim.azimuth), 0);
    const Vector3d middle(0, 0, 0.5 * height_),
        eye = middle + distance * out,
        goal = Vector3d(0, 0, aim.height * height_) + aim.aside * height_ * right;
    const Vector3d up = Eigen::AngleAxisd(aim.roll, (goal - eye).normalized()) * Vector3d::UnitZ();
    room_view.view.camera_from_world = LookAt(eye, goal, up);
    room_views_.push_back(std::move(room_view));
  }

  /// All round, in one or two rounds, at changing heights.
  void Walk(int count) {
    const int rounds = count >= 30 ? 2 : 1;
    const double start = random_.Uniform(0, 2 * kPi), fill = random_.Uniform(0.48, 0.6);
    for (int i = 0; i < count; ++i) {
      const double share = static_cast<double>(i) / count * rounds;
      const double step = 2 * kPi * rounds / count;
      Aim aim;
      aim.azimuth = start + 2 * kPi * share + Jitter(0.25 * step);
      const double high =
          rounds == 1 ? 26 + 12 * std::sin(2.3 * share * 2 * kPi + 1) : (share < 1 ? 17 : 41);
      aim.elevation = (high + Jitter(5)) * kDegree;
      aim.fill = fill * (1 + Jitter(0.12));
      ByHand(aim, 0.06);
      RoomView room_view;
      room_view.part = "walk";
      room_view.gain = 1 + Jitter(0.06);
      Take(aim, room_view, false);
    }
  }

  /// From one side: within so many degrees of the front.
  void Arc(int count, double half_deg) {
    const double fill = random_.Uniform(0.5, 0.62);
    for (int i = 0; i < count; ++i) {
      Aim aim;
      aim.azimuth = -kPi / 2 + kDegree * half_deg * (2.0 * i / (count - 1) - 1 + Jitter(0.05));
      aim.elevation = (22 + 9 * std::sin(2.1 * i) + Jitter(3)) * kDegree;
      aim.fill = fill * (1 + Jitter(0.12));
      ByHand(aim, 0.06);
      RoomView room_view;
      room_view.part = "walk";
      room_view.gain = 1 + Jitter(0.06);
      Take(aim, room_view, false);
    }
  }

  void ByHand(Aim& aim, double by) {
    aim.height += Jitter(by);
    aim.aside += Jitter(by);
    aim.roll += Jitter(0.06);
  }

  /// The mat turns before a camera at a few heights.
  void Rings(int count, bool portrait) {
    const bool hand = plan_.kind == RoomKind::kMatHand;
    const int rings = count >= 30 ? 2 + (plan_.seed % 3 == 0) : (count >= 16 ? 2 : 1);
    int taken = 0;
    for (int ring = 0; ring < rings; ++ring) {
      const int views = count / rings + (ring < count % rings ? 1 : 0);
      Aim aim;
      aim.azimuth = -kPi / 2 + Jitter(0.25);
      aim.elevation = (rings == 1 ? 24 : 14 + 50.0 / rings * ring + Jitter(4)) * kDegree;
      aim.fill = random_.Uniform(0.5, 0.62);
      ByHand(aim, 0.04);
      const double direction = random_.Uniform() < 0.5 ? -1 : 1, start = random_.Uniform(0, 6);
      for (int k = 0; k < views; ++k, ++taken) {
        Aim now = aim;
        RoomView room_view;
        room_view.turn_rad = start + direction * 2 * kPi * (k + Jitter(0.08)) / views;
        room_view.tripod = hand ? -1 : ring;
        if (hand) {
          now.azimuth += Jitter(0.07);
          now.elevation += Jitter(0.05);
          now.fill *= 1 + Jitter(0.06);
          ByHand(now, 0.05);
          room_view.gain = 1 + Jitter(0.05);
        }
        Take(now, room_view, portrait);
      }
    }
  }

  /// Rings, then close-ups by hand between a few turns of the mat; these cut the figure.
  void Both() {
    const int close = plan_.photographs * 2 / 5, groups = std::max(1, close / 4);
    Rings(plan_.photographs - close, plan_.portrait_first);
    double turn = room_views_.back().turn_rad;
    for (int i = 0; i < close; ++i) {
      if (i % 4 == 0) turn += 2 * kPi / groups + Jitter(0.1);
      Aim aim;
      aim.azimuth = -kPi / 2 + (i % 4 - 1.5) * 0.28 + Jitter(0.05);
      aim.elevation = random_.Uniform(10, 38) * kDegree;
      aim.fill = random_.Uniform(0.95, 1.35);
      aim.height = i % 2 ? random_.Uniform(0.25, 0.42) : random_.Uniform(0.55, 0.72);
      aim.aside = Jitter(0.1);
      aim.roll = Jitter(0.08);
      RoomView room_view;
      room_view.turn_rad = turn;
      room_view.part = "close";
      room_view.gain = 1 + Jitter(0.08);
      room_view.lens = plan_.lenses - 1;
      Take(aim, room_view, !plan_.portrait_first);
    }
  }

  const RoomPlan& plan_;
  Random random_;
  double height_ = 0, radius_ = 0;  // of the figure [m]
  Camera lenses_[2];
  std::vector<RoomView> room_views_;
};

}  // namespace

View RoomView::OfFigure() const {
  View of_figure = view;
  const Rigid3 room_from_figure{Eigen::Quaterniond(Eigen::AngleAxisd(turn_rad, Vector3d::UnitZ())),
                                Vector3d::Zero()};
  of_figure.camera_from_world = Compose(view.camera_from_world, room_from_figure);
  return of_figure;
}

Camera TurnedClockwise(const Camera& camera) {
  Camera turned = camera;
  turned.width = camera.height;
  turned.height = camera.width;
  turned.fx = camera.fy;
  turned.fy = camera.fx;
  turned.cx = camera.height - camera.cy;
  turned.cy = camera.cx;
  turned.p1 = camera.p2;
  turned.p2 = -camera.p1;
  return turned;
}

std::vector<RoomView> PlaceRoomViews(const RoomPlan& plan, const PointsX3& figure) {
  return Placing(plan, figure).All();
}

}  // namespace keypose::synth
