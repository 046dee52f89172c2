#include "synth/rooms/furniture.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/values/angles.h"
#include "core/values/size_of.h"
#include "synth/photographs/light.h"

namespace keypose::synth {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kLampRays = 10, kRoomRays = 40;
constexpr double kLampTop = 0.10;      // [rad] half the lamp's size
constexpr double kLampReach = 1.2;     // [m] what is farther away casts no shadow
constexpr double kRoomReach = 0.35;    // [m]
constexpr double kFromSurface = 6e-4;  // [m]
constexpr double kGolden = 2.399963229728653;
constexpr double kMostStretch = 7;  // of a pixel on a surface seen from the side
const Vector3d kLampTint(1.02, 1.0, 0.95), kRoomTint(0.97, 1.0, 1.05);

bool Blocked(const std::vector<const RayScene*>& blockers, const Vector3d& from, const Vector3d& to,
             double reach) {
  return std::any_of(blockers.begin(), blockers.end(),
                     [&](const RayScene* scene) { return scene->Occluded(from, to, 0, reach); });
}

double LampShare(const std::vector<const RayScene*>& blockers, const Vector3d& from,
                 const RoomLight& light) {
  int seen = 0;
  for (int i = 0; i < kLampRays; ++i) {
    const double r = kLampTop * std::sqrt((i + 0.5) / kLampRays), angle = kGolden * i;
    seen += !Blocked(blockers, from,
                     LampDirection(light.azimuth_rad + r * std::cos(angle),
                                   light.elevation_rad + r * std::sin(angle)),
                     kLampReach);
  }
  return static_cast<double>(seen) / kLampRays;
}

double RoomShare(const std::vector<const RayScene*>& blockers, const Vector3d& from,
                 const Vector3d& normal) {
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), normal);
  int seen = 0;
  for (int i = 0; i < kRoomRays; ++i) {
    const double r2 = (i + 0.5) / kRoomRays, r = std::sqrt(r2), angle = kGolden * i;
    const Vector3d to =
        turn * Vector3d(r * std::cos(angle), r * std::sin(angle), std::sqrt(1 - r2));
    seen += !Blocked(blockers, from, to, kRoomReach);
  }
  return static_cast<double>(seen) / kRoomRays;
}

}  // namespace

Vector3d RoomLight::Direction() const { return LampDirection(azimuth_rad, elevation_rad); }

int Furniture::AddPrint(Print print) {
  prints_.push_back(std::make_shared<const Print>(std::move(print)));
  return SizeOf(prints_) - 1;
}

int Furniture::Point(const Vector3d& point, const Vector3d& normal, const Vector2d& place) {
  points_.push_back(point);
  normals_.push_back(normal);
  places_.push_back(place);
  ground_point_.push_back(0);
  return SizeOf(points_) - 1;
}

void Furniture::Face(int a, int b, int c, int print, Part part, bool ground) {
  Eigen::Matrix<double, 3, 2> edges;
  edges << points_[b] - points_[a], points_[c] - points_[a];
  Eigen::Matrix2d on_print;
  on_print << places_[b] - places_[a], places_[c] - places_[a];
  const Eigen::Matrix2d metric = edges.transpose() * edges;
  if (!(std::abs(metric.determinant()) > 1e-20)) return;  // without area
  faces_.push_back({a, b, c});
  place_from_step_.push_back(on_print * metric.inverse() * edges.transpose());
  face_normal_.push_back(Vector3d(edges.col(0)).cross(Vector3d(edges.col(1))).normalized());
  print_.push_back(print);
  part_.push_back(part);
  piece_.push_back(pieces_);
  ground_.push_back(ground ? 1 : 0);
  for (const int corner : {a, b, c}) ground_point_[corner] = ground ? 1 : 0;
}

void Furniture::Add(const Sheet& sheet) {
  const double wide = sheet.across.norm(), high = sheet.down.norm();
  const int nx = std::max(1, static_cast<int>(std::ceil(wide / sheet.cell_m))),
            ny = std::max(1, static_cast<int>(std::ceil(high / sheet.cell_m)));
  const Vector3d normal = sheet.down.cross(sheet.across).normalized();
  const int first = SizeOf(points_);
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i <= nx; ++i) {
      const double u = static_cast<double>(i) / nx, v = static_cast<double>(j) / ny;
      Point(sheet.corner + u * sheet.across + v * sheet.down, normal, {u * wide, v * high});
    }
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      const int a = first + j * (nx + 1) + i, b = a + 1, c = a + nx + 1, d = c + 1;
      Face(a, c, b, sheet.print, sheet.part, sheet.ground);
      Face(b, c, d, sheet.print, sheet.part, sheet.ground);
    }
  ++pieces_;
}

void Furniture::AddBox(const Rigid3& room_from_box, const Vector3d& size,
                       const std::array<int, 6>& prints, Part part, double cell_m) {
  const Vector3d x(size.x(), 0, 0), y(0, size.y(), 0), z(0, 0, size.z());
  // Upper left corner seen from outside, to the right, down. The top is seen with the front below.
  const Vector3d corners[6] = {(-x - y + z) / 2, (x + y + z) / 2,  (-x + y + z) / 2,
                               (x - y + z) / 2,  (-x + y + z) / 2, (-x - y - z) / 2};
  const Vector3d across[6] = {x, -x, -y, y, x, x}, down[6] = {-z, -z, -z, -z, -y, y};
  for (int side = 0; side < 6; ++side) {
    if (prints[side] < 0) continue;
    Add({room_from_box * corners[side], room_from_box.rotation * across[side],
         room_from_box.rotation * down[side], prints[side], part, cell_m, false});
  }
}

void Furniture::AddDrum(const Rigid3& room_from_drum, double radius, double height, int side,
                        int lid, Part part, bool ground_lid) {
  constexpr int kAround = 48;
  std::vector<std::vector<Vector3d>> rows(2);
  std::vector<std::vector<Vector2d>> places(2);
  for (int i = 0; i <= kAround; ++i) {
    const double angle = 2 * kPi * i / kAround - kPi / 2;
    const Vector3d out(std::cos(angle), std::sin(angle), 0);
    for (int row = 0; row < 2; ++row) {
      rows[row].push_back(room_from_drum *
                          (radius * out + (row == 0 ? height : 0) * Vector3d::UnitZ()));
      places[row].emplace_back(2 * kPi * radius * i / kAround, row == 0 ? 0 : height);
    }
  }
  if (side >= 0) AddPatch(rows, places, side, part, true);
  if (lid < 0) return;
  const Vector3d up = room_from_drum.rotation * Vector3d::UnitZ();
  const Print& top = *prints_[lid];
  const Vector2d middle(top.width_m() / 2, top.height_m() / 2);
  const int hub = Point(room_from_drum * Vector3d(0, 0, height), up, middle);
  for (int i = 0; i <= kAround; ++i) {
    const double angle = 2 * kPi * i / kAround - kPi / 2;
    Point(rows[0][i], up, middle + radius * Vector2d(std::cos(angle), -std::sin(angle)));
  }
  for (int i = 0; i < kAround; ++i) Face(hub, hub + 1 + i, hub + 2 + i, lid, part, ground_lid);
  ++pieces_;
}

void Furniture::AddPatch(const std::vector<std::vector<Vector3d>>& rows,
                         const std::vector<std::vector<Vector2d>>& places, int print, Part part,
                         bool closed) {
  const int height = SizeOf(rows), width = SizeOf(rows.front());
  const auto column = [&](int i) {
    if (closed) return (i + width - 1) % (width - 1);
    return std::clamp(i, 0, width - 1);
  };
  const int first = SizeOf(points_);
  for (int j = 0; j < height; ++j)
    for (int i = 0; i < width; ++i) {
      const Vector3d along = rows[j][column(i + 1)] - rows[j][column(i - 1)],
                     down = rows[std::min(j + 1, height - 1)][i] - rows[std::max(j - 1, 0)][i];
      Point(rows[j][i], down.cross(along).normalized(), places[j][i]);
    }
  for (int j = 0; j + 1 < height; ++j)
    for (int i = 0; i + 1 < width; ++i) {
      const int a = first + j * width + i, b = a + 1, c = a + width, d = c + 1;
      Face(a, c, b, print, part, false);
      Face(b, c, d, print, part, false);
    }
  ++pieces_;
}

Mesh Furniture::AsMesh() const {
  Mesh mesh;
  mesh.points.resize(std::ssize(points_), 3);
  for (std::size_t i = 0; i < points_.size(); ++i) mesh.points.row(i) = points_[i].transpose();
  mesh.faces.resize(std::ssize(faces_), 3);
  for (std::size_t i = 0; i < faces_.size(); ++i)
    mesh.faces.row(i) << faces_[i][0], faces_[i][1], faces_[i][2];
  return mesh;
}

Mesh Furniture::Standing() const {
  Mesh mesh = AsMesh();
  Eigen::Index kept = 0;
  for (std::size_t i = 0; i < faces_.size(); ++i)
    if (!ground_[i]) mesh.faces.row(kept++) = mesh.faces.row(i).eval();
  mesh.faces.conservativeResize(kept, 3);
  return mesh;
}

void Furniture::Finish() {
  const Mesh mesh = AsMesh();
  scene_ = std::make_unique<RayScene>(mesh.points, mesh.faces);
  lamp_.assign(points_.size(), 1.0f);
  room_.assign(points_.size(), 1.0f);
}

void Furniture::Light(const std::vector<const RayScene*>& blockers, const RoomLight& light,
                      bool turns, bool ground) {
  const Vector3d to_lamp = light.Direction();
  const auto bake = [&](std::int64_t i) {
    if (ground_point_[i] && !ground) return;
    const Vector3d from = points_[i] + kFromSurface * normals_[i];
    room_[i] = static_cast<float>(RoomShare(blockers, from, normals_[i]));
    if (turns) return;
    lamp_[i] =
        normals_[i].dot(to_lamp) <= 0 ? 0.0f : static_cast<float>(LampShare(blockers, from, light));
  };
  ParallelFor(std::ssize(points_), bake, 64);
}

Vector3d Furniture::Color(int face, const Vector2d& place, const Look& look,
                          const Vector3d& normal) const {
  const Print& print = *prints_[print_[face]];
  const Vector3d ray = look.ray.normalized();
  const double slant = std::max(std::abs(normal.dot(ray)), 1 / kMostStretch);
  // On a surface seen from the side a pixel is an ellipse: samples along it.
  const int samples = static_cast<int>(std::ceil(1 / slant - 0.25));
  if (samples <= 1) return print.At(place.x(), place.y(), look.pixel_m);
  const Vector3d long_way = (ray - normal * normal.dot(ray)).normalized();
  const Vector2d step = place_from_step_[face] * long_way * (look.pixel_m / slant / samples);
  Vector3d sum = Vector3d::Zero();
  for (int i = 0; i < samples; ++i) {
    const Vector2d at = place + (i - 0.5 * (samples - 1)) * step;
    sum += print.At(at.x(), at.y(), look.pixel_m);
  }
  return sum / samples;
}

Vector3d Furniture::Shade(const RayScene::Hit& hit, const Look& look,
                          const RoomLight& light) const {
  const std::array<int, 3>& f = faces_[hit.face];
  const double w[3] = {1 - hit.u - hit.v, hit.u, hit.v};
  Vector3d normal = Vector3d::Zero();
  Vector2d place = Vector2d::Zero();
  double lamp = 0, room = 0;
  for (int k = 0; k < 3; ++k) {
    normal += w[k] * normals_[f[k]];
    place += w[k] * places_[f[k]];
    lamp += w[k] * lamp_[f[k]];
    room += w[k] * room_[f[k]];
  }
  normal.normalize();
  const double facing = std::max(0.0, normal.dot(look.to_lamp));
  const Vector3d arrives = light.lamp * lamp * look.lamp_share * facing * kLampTint +
                           light.ambient * room * look.room_share * kRoomTint;
  return Color(hit.face, place, look, normal).cwiseProduct(arrives);
}

}  // namespace keypose::synth
