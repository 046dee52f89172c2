#include "composite/locating/candidates/shape_search.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "core/numbers/parallel.h"
#include "core/numbers/rotations.h"
#include "core/pictures/render.h"
#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"

namespace keypose::composite {
namespace {

constexpr int kDirections = 812, kSide = 64;
constexpr int kAngles = 72, kRadii = 20;
constexpr double kReach = 3.2;   // of the polar drawing, in roots of area over pi
constexpr double kApart = 0.21;  // rad between candidates: 12 degrees
constexpr int kPeaks = 3;        // turns of one drawing that are kept

/// Occupancy on the plane z = 1 before a camera.
using Occupied = std::function<bool(const Eigen::Vector2d&)>;

struct Moments {
  double area = 0;
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
  double radius() const { return std::sqrt(area / std::numbers::pi); }
};

/// Cells of equal angle and width; each has the root of its area as weight, so that scalar products
/// are areas.
Eigen::VectorXf PolarCells(const Occupied& occupied, const Moments& moments) {
  Eigen::VectorXf cells(kAngles * kRadii);
  for (int r = 0; r < kRadii; ++r) {
    const double radius = kReach * (r + 0.5) / kRadii;
    for (int a = 0; a < kAngles; ++a) {
      const double angle = 2 * std::numbers::pi * a / kAngles;
      const Eigen::Vector2d at =
          moments.centroid +
          moments.radius() * radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      cells[r * kAngles + a] = occupied(at) ? static_cast<float>(std::sqrt(radius)) : 0.0f;
    }
  }
  return cells;
}

/// The product of two drawings, the second turned by each step of angle.
std::vector<double> Products(const Eigen::VectorXf& fixed, const Eigen::VectorXf& turned) {
  std::vector<double> products(kAngles, 0.0);
  for (int shift = 0; shift < kAngles; ++shift) {
    float sum = 0;
    for (int r = 0; r < kRadii; ++r) {
      const auto a = fixed.segment(r * kAngles, kAngles);
      const auto b = turned.segment(r * kAngles, kAngles);
      sum +=
          a.tail(kAngles - shift).dot(b.head(kAngles - shift)) + a.head(shift).dot(b.tail(shift));
    }
    products[shift] = static_cast<double>(sum);
  }
  return products;
}

Rigid3 LookingFrom(const Figure& figure, int direction, double distance) {
  const double z = 1 - (2 * direction + 1.0) / kDirections;
  const double r = std::sqrt(1 - z * z), a = std::numbers::pi * (3 - std::sqrt(5.0)) * direction;
  const Eigen::Vector3d towards(r * std::cos(a), r * std::sin(a), z);
  const Eigen::Vector3d up =
      std::abs(z) > 0.98 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitZ();
  return LookAt(figure.center + distance * towards, figure.center, up);
}

/// A drawing of kSide x kSide pixels of what lies before a camera that looks at the mesh.
struct Raster64 {
  std::vector<char> inside = std::vector<char>(kSide * kSide, 0);
  double extent = 0;  ///< half of its side, on the plane z = 1

  Eigen::Vector2d Place(int x, int y) const {
    return Eigen::Vector2d(2 * (x + 0.5) / kSide - 1, 2 * (y + 0.5) / kSide - 1) * extent;
  }
  bool At(const Eigen::Vector2d& p) const {
    const int x = static_cast<int>(std::floor((p.x() / extent + 1) / 2 * kSide));
    const int y = static_cast<int>(std::floor((p.y() / extent + 1) / 2 * kSide));
    return x >= 0 && y >= 0 && x < kSide && y < kSide && inside[y * kSide + x];
  }
};

Raster64 DrawnFrom(const Figure& figure, const Rigid3& pose) {
  Raster64 raster;
  for (Eigen::Index v = 0; v < figure.points.rows(); ++v) {
    const Eigen::Vector3d x = pose * figure.points.row(v).transpose();
    if (x.z() > 0)
      raster.extent = std::max(raster.extent, x.head<2>().cwiseAbs().maxCoeff() / x.z());
  }
  raster.extent *= 1.02;
  const Eigen::Matrix3d turn = pose.rotation.conjugate().toRotationMatrix();
  const Eigen::Vector3d eye = pose.Inverse().translation;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const Eigen::Vector3d ray = turn * raster.Place(x, y).homogeneous();
      raster.inside[y * kSide + x] =
          figure.scene.Occluded(eye, ray, 0, std::numeric_limits<double>::infinity());
    }
  return raster;
}

Moments MomentsOf(const Raster64& raster) {
  Moments moments;
  const double cell = std::pow(2 * raster.extent / kSide, 2);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x)
      if (raster.inside[y * kSide + x]) {
        moments.area += cell;
        moments.centroid += cell * raster.Place(x, y);
      }
  if (moments.area > 0) moments.centroid /= moments.area;
  return moments;
}

/// The mean direction of a matte's pixels, and their solid angle.
struct MatteCone {
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
  double solid_angle = 0;
};
MatteCone ConeOf(const Camera& camera, const Image8& matte) {
  MatteCone cone;
  for (int y = 0; y < matte.height; ++y)
    for (int x = 0; x < matte.width; ++x) {
      if (matte.at(x, y)[0] <= 127) continue;
      const Eigen::Vector3d ray = camera.Unproject({x + 0.5, y + 0.5});
      const double angle = 1 / (camera.fx * camera.fy * std::pow(ray.norm(), 3));
      cone.axis += angle * ray.normalized();
      cone.solid_angle += angle;
    }
  if (cone.solid_angle > 0) cone.axis.normalize();
  return cone;
}

/// A matte as seen by a camera that is turned towards it.
struct TurnedMatte {
  Eigen::Quaterniond turned_from_camera;
  Moments moments;
  Occupied occupied;
};
TurnedMatte TurnTowards(const Camera& camera, const Image8& matte) {
  const MatteCone cone = ConeOf(camera, matte);
  TurnedMatte turned;
  turned.turned_from_camera =
      Eigen::Quaterniond::FromTwoVectors(cone.axis, Eigen::Vector3d::UnitZ());
  const Eigen::Matrix3d back = turned.turned_from_camera.conjugate().toRotationMatrix();
  for (int y = 0; y < matte.height; ++y)
    for (int x = 0; x < matte.width; ++x) {
      if (matte.at(x, y)[0] <= 127) continue;
      const Eigen::Vector3d ray = camera.Unproject({x + 0.5, y + 0.5});
      const Eigen::Vector3d seen = back.transpose() * ray;
      const double area = std::pow(1 / seen.z(), 3) / (camera.fx * camera.fy);
      turned.moments.area += area;
      turned.moments.centroid += area * seen.head<2>() / seen.z();
    }
  if (turned.moments.area > 0) turned.moments.centroid /= turned.moments.area;
  turned.occupied = [&camera, &matte, back](const Eigen::Vector2d& p) {
    const Eigen::Vector3d ray = back * p.homogeneous();
    if (ray.z() <= 0) return false;
    const Eigen::Vector2d pixel = camera.Project(ray);
    if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < matte.width && pixel.y() < matte.height))
      return false;
    return matte.at(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()))[0] > 127;
  };
  return turned;
}

/// The steps of angle where products are greatest among their neighbours, the best few.
std::vector<int> Peaks(const std::vector<double>& products) {
  std::vector<int> peaks;
  for (int s = 0; s < kAngles; ++s)
    if (products[s] >= products[(s + 1) % kAngles] &&
        products[s] > products[(s + kAngles - 1) % kAngles])
      peaks.push_back(s);
  std::stable_sort(peaks.begin(), peaks.end(),
                   [&](int a, int b) { return products[a] > products[b]; });
  if (SizeOf(peaks) > kPeaks) peaks.resize(kPeaks);
  return peaks;
}

/// The place for which a drawing, turned by `roll` about its centroid, scaled and shifted, becomes
/// the matte.
/// @param drawn     camera from mesh of the drawing, which has `centroid` and `radius`
Rigid3 PoseOf(const Rigid3& drawn, const Eigen::Vector3d& mesh_center,
              const Eigen::Vector2d& centroid, double radius, double roll_rad,
              const TurnedMatte& turned) {
  const Eigen::Quaterniond roll(Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitZ()));
  const Eigen::Vector3d center = drawn * mesh_center;
  const Eigen::Vector2d aside = center.head<2>() - center.z() * centroid;
  const Eigen::Vector3d rolled = roll * Eigen::Vector3d(aside.x(), aside.y(), 0);
  const double depth = center.z() * radius / turned.moments.radius();
  const Eigen::Vector2d across = rolled.head<2>() + depth * turned.moments.centroid;
  Rigid3 pose{roll * drawn.rotation, Eigen::Vector3d::Zero()};
  pose.translation = Eigen::Vector3d(across.x(), across.y(), depth) - pose.rotation * mesh_center;
  return Compose({turned.turned_from_camera.conjugate(), Eigen::Vector3d::Zero()}, pose);
}

/// The best candidates that are kApart from better ones.
std::vector<ShapeCandidate> BestApart(std::vector<ShapeCandidate> all, int most) {
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.overlap > b.overlap; });
  const double apart = RotationDifference(Eigen::Quaterniond::Identity(),
                                          QuaternionOf(Eigen::Vector3d(kApart, 0, 0)));
  std::vector<ShapeCandidate> best;
  for (const ShapeCandidate& candidate : all) {
    if (SizeOf(best) >= most) break;
    const bool known = std::any_of(best.begin(), best.end(), [&](const ShapeCandidate& other) {
      return RotationDifference(candidate.camera_from_mesh.rotation,
                                other.camera_from_mesh.rotation) < apart;
    });
    if (!known) best.push_back(candidate);
  }
  return best;
}

}  // namespace

double AngularRadius(const Camera& camera, const Image8& matte) {
  return std::sqrt(ConeOf(camera, matte).solid_angle / std::numbers::pi);
}

ShapeSearch::ShapeSearch(const Figure& figure, double angular_radius)
    : figure_(figure), drawings_(kDirections) {
  // A convex body's mean shadow is a quarter of its surface (Cauchy).
  const double shadow =
      std::sqrt(SurfaceArea(figure.points, figure.faces) / (4 * std::numbers::pi));
  const double distance = std::max(shadow / std::max(angular_radius, 1e-3), 1.5 * figure.radius);
  ParallelFor(kDirections, [&](std::int64_t d) {
    Drawing& drawing = drawings_[d];
    drawing.camera_from_mesh = LookingFrom(figure, static_cast<int>(d), distance);
    const Raster64 raster = DrawnFrom(figure, drawing.camera_from_mesh);
    const Moments moments = MomentsOf(raster);
    drawing.centroid = moments.centroid;
    drawing.radius = moments.radius();
    drawing.cells = PolarCells([&](const Eigen::Vector2d& p) { return raster.At(p); }, moments);
    drawing.squares = static_cast<double>(drawing.cells.squaredNorm());
  });
}

std::vector<ShapeCandidate> ShapeSearch::Find(const Camera& camera, const Image8& matte,
                                              int most) const {
  const TurnedMatte turned = TurnTowards(camera, matte);
  if (turned.moments.area <= 0) return {};
  const Eigen::VectorXf cells = PolarCells(turned.occupied, turned.moments);
  const double squares = static_cast<double>(cells.squaredNorm());
  std::vector<std::vector<ShapeCandidate>> of_drawing(drawings_.size());
  ParallelFor(SizeOf(drawings_), [&](std::int64_t d) {
    const Drawing& drawing = drawings_[d];
    if (drawing.radius <= 0) return;
    const std::vector<double> products = Products(cells, drawing.cells);
    for (const int s : Peaks(products)) {
      const Rigid3 pose = PoseOf(drawing.camera_from_mesh, figure_.center, drawing.centroid,
                                 drawing.radius, 2 * std::numbers::pi * s / kAngles, turned);
      of_drawing[d].push_back({pose, products[s] / (squares + drawing.squares - products[s])});
    }
  });
  std::vector<ShapeCandidate> all;
  for (const auto& list : of_drawing) all.insert(all.end(), list.begin(), list.end());
  return BestApart(std::move(all), most);
}

}  // namespace keypose::composite
