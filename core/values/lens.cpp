#include "core/values/lens.h"

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace keypose {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPi_rad = 3.14159265358979323846;
constexpr double kTiny = 1e-12;

/// r over tan(theta) of the models that depend on the angle alone.
std::optional<Vector2d> ByAngle(const Vector3d& x, double r) {
  const double across = x.head<2>().norm();
  if (across < kTiny * std::abs(x.z())) return Vector2d(x.head<2>() / x.z());
  return Vector2d(x.head<2>() * (r / across));
}

std::optional<Vector2d> Over(const Vector3d& x, double depth) {
  if (!(depth > kTiny * x.norm())) return std::nullopt;
  return Vector2d(x.head<2>() / depth);
}

/// The division model's own inverse: the root of k r^2 rho - r z + rho that lies nearest the axis.
std::optional<Vector2d> ByDivision(const Vector3d& x, double k) {
  const double under = x.z() * x.z() - 4 * k * x.head<2>().squaredNorm();
  if (under < 0) return std::nullopt;
  return Over(x, 0.5 * (x.z() + std::sqrt(under)));
}

std::optional<Vector2d> ByFieldOfView(const Vector3d& x, double w) {
  if (x.z() <= 0) return std::nullopt;
  if (std::abs(w) < 1e-6) return Over(x, x.z());
  const double scale = 2 * std::tan(0.5 * w);
  const double across = x.head<2>().norm() / x.z();
  if (across < kTiny) return Vector2d(x.head<2>() / x.z() * (scale / w));
  return Vector2d(x.head<2>() / x.z() * (std::atan(across * scale) / (w * across)));
}

std::optional<Vector2d> Projected(const Lens& lens, const Vector3d& x) {
  const double theta = std::atan2(x.head<2>().norm(), x.z()), d = x.norm();
  const double a = lens.shape[0], b = lens.shape[1];
  if (!(d > 0)) return std::nullopt;
  switch (lens.projection) {
    case LensProjection::kPerspective:
      return Over(x, x.z());
    case LensProjection::kEquidistant:
      return ByAngle(x, theta);
    case LensProjection::kEquisolid:
      return ByAngle(x, 2 * std::sin(0.5 * theta));
    case LensProjection::kStereographic:
      return ByAngle(x, 2 * std::tan(0.5 * theta));
    case LensProjection::kFieldOfView:
      return ByFieldOfView(x, a);
    case LensProjection::kDivision:
      return ByDivision(x, a);
    case LensProjection::kUnified:
      return Over(x, x.z() + a * d);
    case LensProjection::kEnhanced:
      return Over(x,
                  a * std::sqrt(b * x.head<2>().squaredNorm() + x.z() * x.z()) + (1 - a) * x.z());
    case LensProjection::kDoubleSphere: {
      const double z = a * d + x.z();
      return Over(x, b * std::sqrt(x.head<2>().squaredNorm() + z * z) + (1 - b) * z);
    }
  }
  return std::nullopt;
}

/// Horner's scheme for 1 + c[0] t + c[1] t^2 + ...
template <std::size_t N>
double OnePlus(const std::array<double, N>& c, double t) {
  double sum = 0;
  for (std::size_t i = N; i-- > 0;) sum = (sum + c[i]) * t;
  return 1 + sum;
}

Vector2d Sideways(const Lens& lens, const Vector2d& p) {
  const double x = p.x(), y = p.y(), r2 = p.squaredNorm(), r4 = r2 * r2;
  const double grows = 1 + lens.p3 * r2 + lens.p4 * r4;
  const Vector2d tangential(2 * lens.p1 * x * y + lens.p2 * (r2 + 2 * x * x),
                            lens.p1 * (r2 + 2 * y * y) + 2 * lens.p2 * x * y);
  const Vector2d prism(lens.prism[0] * r2 + lens.prism[1] * r4,
                       lens.prism[2] * r2 + lens.prism[3] * r4);
  return grows * tangential + prism;
}

std::optional<Vector2d> Distorted(const Lens& lens, const Vector2d& p) {
  const double r2 = p.squaredNorm(), divisor = OnePlus(lens.divisor, r2);
  if (!(divisor > kTiny)) return std::nullopt;  // beyond the pole of a rational lens
  const Vector2d radial = p * (OnePlus(lens.radial, r2) / divisor);
  return Vector2d(radial + Sideways(lens, lens.radial_first ? radial : p));
}

/// The sensor turned about x, then about y; the plane is then seen along the lens's axis again.
std::optional<Vector2d> Tilted(const Lens& lens, const Vector2d& p) {
  if (lens.tilt[0] == 0 && lens.tilt[1] == 0) return p;
  const double cx = std::cos(lens.tilt[0]), sx = std::sin(lens.tilt[0]),
               cy = std::cos(lens.tilt[1]), sy = std::sin(lens.tilt[1]);
  Matrix3d about_x, about_y, onto;
  about_x << 1, 0, 0, 0, cx, sx, 0, -sx, cx;
  about_y << cy, 0, -sy, 0, 1, 0, sy, 0, cy;
  const Matrix3d turn = about_y * about_x;
  onto << turn(2, 2), 0, -turn(0, 2), 0, turn(2, 2), -turn(1, 2), 0, 0, 1;
  const Vector3d q = onto * turn * p.homogeneous();
  if (!(q.z() > kTiny)) return std::nullopt;
  return Vector2d(q.head<2>() / q.z());
}

/// A direction by the angle from the axis and the way round it: `a` has the angle's length.
Vector3d DirectionAt(const Vector2d& a) {
  const double angle = a.norm();
  const double over = angle < 1e-8 ? 1 : std::sin(angle) / angle;
  return {over * a.x(), over * a.y(), std::cos(angle)};
}

/// Newton's method for the direction of one pixel.
class RaySearch {
 public:
  explicit RaySearch(const Lens& lens) : lens_(lens) {}

  /// @param a  the start, and the result
  bool Find(const Vector2d& pixel, Vector2d* a) {
    constexpr int kMostSteps = 30;
    Vector2d at = *a;
    std::optional<Vector2d> seen = lens_.Project(DirectionAt(at));
    for (int i = 0; i < kMostSteps && seen; ++i) {
      const Vector2d miss = *seen - pixel;
      const std::optional<Matrix2d> slope = SlopeAt(at);
      if (!slope || !(slope->determinant() > 0)) return false;
      if (miss.norm() < kEnough_px) {
        *a = at;
        return true;
      }
      const Vector2d step = slope->inverse() * miss;
      if (!StepAlong(step, pixel, miss.norm(), &at, &seen))
        return miss.norm() < kStated_px && Keep(at, a);
    }
    return false;
  }

 private:
  static constexpr double kEnough_px = 1e-10, kStated_px = 1e-8;

  static bool Keep(const Vector2d& at, Vector2d* a) {
    *a = at;
    return true;
  }
  /// Halves the step until it brings the projection nearer.
  bool StepAlong(Vector2d step, const Vector2d& pixel, double before, Vector2d* at,
                 std::optional<Vector2d>* seen) const {
    for (int halved = 0; halved < 12; ++halved, step *= 0.5) {
      const Vector2d next = *at - step;
      if (next.norm() >= kPi_rad) continue;
      const std::optional<Vector2d> there = lens_.Project(DirectionAt(next));
      if (!there || !((*there - pixel).norm() < before)) continue;
      *at = next;
      *seen = there;
      return true;
    }
    return false;
  }
  std::optional<Matrix2d> SlopeAt(const Vector2d& a) const {
    constexpr double kStep = 1e-6;
    Matrix2d slope;
    for (int k = 0; k < 2; ++k) {
      const Vector2d by = kStep * Vector2d::Unit(k);
      const auto after = lens_.Project(DirectionAt(a + by)),
                 before = lens_.Project(DirectionAt(a - by));
      if (!after || !before) return std::nullopt;
      slope.col(k) = (*after - *before) / (2 * kStep);
    }
    return slope;
  }

  const Lens& lens_;
};

bool HasOnlyBrown(const Lens& lens) {
  const auto zero = [](double number) { return number == 0; };
  return lens.projection == LensProjection::kPerspective && lens.skew == 0 && lens.p3 == 0 &&
         lens.p4 == 0 && !lens.radial_first &&
         std::all_of(lens.radial.begin() + 2, lens.radial.end(), zero) &&
         std::all_of(lens.divisor.begin(), lens.divisor.end(), zero) &&
         std::all_of(lens.prism.begin(), lens.prism.end(), zero) &&
         std::all_of(lens.tilt.begin(), lens.tilt.end(), zero);
}

Camera WithNumbers(Camera camera, const Eigen::Matrix<double, 8, 1>& n) {
  camera.fx = n[0];
  camera.fy = n[1];
  camera.cx = n[2];
  camera.cy = n[3];
  camera.k1 = n[4];
  camera.k2 = n[5];
  camera.p1 = n[6];
  camera.p2 = n[7];
  return camera;
}

struct Sight {
  Vector2d pixel;
  Vector3d ray;
};

/// A grid of pixels over the picture, its edges too, with their directions; empty where some have
/// none that a camera could have.
std::vector<Sight> SightsOf(const Lens& lens, int columns, int rows) {
  constexpr double kLeastDepth = 0.15;  // of a unit ray: 81 degrees from the axis
  const double width = lens.width > 0 ? lens.width : 2 * lens.cx,
               height = lens.height > 0 ? lens.height : 2 * lens.cy;
  if (!(width > 0 && height > 0)) return {};
  std::vector<Sight> sights;
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      const Vector2d pixel(width * c / (columns - 1), height * r / (rows - 1));
      const std::optional<Vector3d> ray = lens.Ray(pixel);
      if (!ray || ray->z() < kLeastDepth) return {};
      sights.push_back({pixel, *ray});
    }
  return sights;
}

/// Least squares over the sights, by Gauss and Newton.
Camera FittedTo(const std::vector<Sight>& sights, const Camera& start) {
  constexpr int kRounds = 12;
  Eigen::Matrix<double, 8, 1> numbers;
  numbers << start.fx, start.fy, start.cx, start.cy, 0, 0, 0, 0;
  const auto rows = 2 * static_cast<Eigen::Index>(sights.size());
  for (int round = 0; round < kRounds; ++round) {
    const Camera camera = WithNumbers(start, numbers);
    Eigen::MatrixXd slope(rows, 8);
    Eigen::VectorXd miss(rows);
    for (std::size_t i = 0; i < sights.size(); ++i) {
      const auto at = 2 * static_cast<Eigen::Index>(i);
      miss.segment<2>(at) = sights[i].pixel - camera.Project(sights[i].ray);
      for (int k = 0; k < 8; ++k) {
        const double by = k < 4 ? 1e-2 : 1e-5;
        Eigen::Matrix<double, 8, 1> up = numbers, down = numbers;
        up[k] += by;
        down[k] -= by;
        slope.block<2, 1>(at, k) = (WithNumbers(start, up).Project(sights[i].ray) -
                                    WithNumbers(start, down).Project(sights[i].ray)) /
                                   (2 * by);
      }
    }
    const Eigen::VectorXd scale = slope.colwise().norm().cwiseMax(1e-12).cwiseInverse();
    numbers += scale.asDiagonal() * (slope * scale.asDiagonal()).colPivHouseholderQr().solve(miss);
  }
  return WithNumbers(start, numbers);
}

/// Both ways: where a point is seen, and where a pixel looks.
bool Agrees(const Camera& camera, const std::vector<Sight>& sights) {
  return std::all_of(sights.begin(), sights.end(), [&](const Sight& sight) {
    const double off = (camera.Project(sight.ray) - sight.pixel).norm(),
                 back = (camera.Project(camera.Unproject(sight.pixel)) - sight.pixel).norm();
    const Vector3d looks = camera.Unproject(sight.pixel).normalized();
    const double aside = (looks - sight.ray).norm() * std::max(camera.fx, camera.fy);
    return off <= kSameLens_px && back <= kSameLens_px && aside <= 2 * kSameLens_px;
  });
}

}  // namespace

std::optional<Vector2d> Lens::Project(const Vector3d& x_in_camera) const {
  std::optional<Vector2d> p = Projected(*this, x_in_camera);
  if (p) p = Distorted(*this, *p);
  if (p) p = Tilted(*this, *p);
  if (!p || !p->allFinite()) return std::nullopt;
  return Vector2d(fx * p->x() + skew * p->y() + cx, fy * p->y() + cy);
}

std::optional<Vector3d> Lens::Ray(const Vector2d& pixel) const {
  // Small parts of the way: Newton's method then stays with the direction nearest the axis, where a
  // polynomial sees several at one pixel.
  constexpr int kParts = 8;
  RaySearch search(*this);
  const Vector2d middle(cx, cy);
  Vector2d a = Vector2d::Zero();
  for (int part = 1; part <= kParts; ++part)
    if (!search.Find(middle + (pixel - middle) * part / kParts, &a)) return std::nullopt;
  return DirectionAt(a).normalized();
}

Lens LensOf(const Camera& camera) {
  Lens lens;
  lens.model = "OPENCV";
  lens.width = camera.width;
  lens.height = camera.height;
  lens.fx = camera.fx;
  lens.fy = camera.fy;
  lens.cx = camera.cx;
  lens.cy = camera.cy;
  lens.radial = {camera.k1, camera.k2, 0, 0, 0, 0};
  lens.p1 = camera.p1;
  lens.p2 = camera.p2;
  return lens;
}

std::optional<Camera> CameraOf(const Lens& lens) {
  Camera camera = UndistortedCamera(lens);
  if (HasOnlyBrown(lens)) {
    camera.k1 = lens.radial[0];
    camera.k2 = lens.radial[1];
    camera.p1 = lens.p1;
    camera.p2 = lens.p2;
    return camera;
  }
  const std::vector<Sight> coarse = SightsOf(lens, 17, 13);
  if (coarse.empty()) return std::nullopt;
  camera = FittedTo(coarse, camera);
  const bool possible = camera.fx > 0 && camera.fy > 0;
  if (!possible || !Agrees(camera, coarse) || !Agrees(camera, SightsOf(lens, 32, 24)))
    return std::nullopt;
  return camera;
}

Camera UndistortedCamera(const Lens& lens) {
  Camera camera;
  camera.width = lens.width;
  camera.height = lens.height;
  camera.fx = lens.fx;
  camera.fy = lens.fy;
  camera.cx = lens.cx;
  camera.cy = lens.cy;
  if (HasOnlyBrown(lens)) return camera;
  // Unified and other lenses scale their middle by more than fx.
  constexpr double kStep = 1e-6;
  const auto middle = lens.Project({0, 0, 1}), right = lens.Project({kStep, 0, 1}),
             below = lens.Project({0, kStep, 1});
  if (!middle || !right || !below) return camera;
  camera.fx = (*right - *middle).x() / kStep;
  camera.fy = (*below - *middle).y() / kStep;
  return camera;
}

}  // namespace keypose
