// Every lens that camera files describe: one chain of steps from a direction to a pixel, of which
// each model of COLMAP, OpenCV, Kalibr, Metashape and nerfstudio is a case.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/values/camera.h"

namespace keypose {

/// How a direction (x, y, z) becomes a point of the plane, before it is distorted. r is the point's
/// distance from the middle, theta the direction's angle from the axis.
enum class LensProjection {
  kPerspective,    ///< r = tan theta
  kEquidistant,    ///< r = theta
  kEquisolid,      ///< r = 2 sin(theta / 2)
  kStereographic,  ///< r = 2 tan(theta / 2)
  kFieldOfView,    ///< r = atan(2 tan(theta) tan(w / 2)) / w, w = shape[0] (Devernay & Faugeras)
  kDivision,       ///< tan theta = r / (1 + k r^2), k = shape[0] (Fitzgibbon)
  kUnified,        ///< (x, y) / (z + xi d), d the length of (x, y, z), xi = shape[0] (Mei)
  kEnhanced,       ///< (x, y) / (a sqrt(b (x^2 + y^2) + z^2) + (1 - a) z), a, b = shape (EUCM)
  kDoubleSphere    ///< xi, alpha = shape (Usenko)
};

/// A lens and its picture. Lengths in pixels, pixel centres at .5 as in Camera; the camera's frame
/// has x right, y down, z forward. The steps, in order:
///  1. projection: direction to (x, y), with r^2 = x^2 + y^2
///  2. radial: (x, y) times (1 + sum radial[i] r^(2i+2)) / (1 + sum divisor[i] r^(2i+2))
///  3. tangential: + (2 p1 x y + p2 (r^2 + 2 x^2), p1 (r^2 + 2 y^2) + 2 p2 x y) (1 + p3 r^2 + p4
///  r^4),
///     and prism: + (s0 r^2 + s1 r^4, s2 r^2 + s3 r^4); in x, y before step 2, or after it where
///     `radial_first`
///  4. tilt of the sensor about x and y [rad], as OpenCV's tau_x, tau_y
///  5. u = fx x + skew y + cx, v = fy y + cy
struct Lens {
  std::string model;  ///< as its file calls it, such as "OPENCV_FISHEYE"; for messages
  int width = 0, height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0, skew = 0;
  LensProjection projection = LensProjection::kPerspective;
  std::array<double, 2> shape{};
  std::array<double, 6> radial{};
  std::array<double, 3> divisor{};
  double p1 = 0, p2 = 0, p3 = 0, p4 = 0;
  std::array<double, 4> prism{};
  std::array<double, 2> tilt{};
  bool radial_first = false;

  bool operator==(const Lens&) const = default;

  /// Where a point of the camera's frame is seen; none where this lens cannot see it.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& x_in_camera) const;
  /// The unit direction that is seen at a pixel; none where no direction near the axis is (beyond
  /// where the lens's polynomial turns back). Its projection is within 1e-8 px of the pixel.
  /// By Newton's method, along the line from the principal point.
  std::optional<Eigen::Vector3d> Ray(const Eigen::Vector2d& pixel) const;
};

/// A lens seen and its place: what a camera file says of a picture.
struct LensView {
  std::string name;
  Lens lens;
  Rigid3 camera_from_world;
};

Lens LensOf(const Camera& camera);

/// How far a Camera that stands for a Lens may be off, in the worst place of the picture: less than
/// the calibration that made the lens knows it by.
inline constexpr double kSameLens_px = 0.1;

/// The camera that maps as the lens does: exactly, where its model holds the lens; else the nearest
/// one, where that is within kSameLens_px everywhere in the picture (such as of a small k3, or of a
/// fisheye of 60 degrees). None: only undistorting the picture helps.
/// Cost: a millisecond where it must be searched.
std::optional<Camera> CameraOf(const Lens& lens);

/// The camera without distortion that the lens's pictures are undistorted to: their size, and the
/// lens's scale at its middle.
Camera UndistortedCamera(const Lens& lens);

}  // namespace keypose
