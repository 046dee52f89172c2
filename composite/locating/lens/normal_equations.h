// Least squares for a camera and the place of a mesh before it: derivatives of pixels, and one
// Gauss-Newton step.
#pragma once

#include <Eigen/Core>
#include <array>

#include "core/values/camera.h"

namespace keypose::composite {

/// Where a mesh is seen from, and by which lens.
struct Placement {
  Camera camera;
  Rigid3 camera_from_mesh;

  /// Not meaningful behind the camera.
  Eigen::Vector2d Project(const Eigen::Vector3d& x_in_mesh) const {
    return camera.Project(camera_from_mesh * x_in_mesh);
  }
  /// With the camera for a picture scaled by `factor`.
  Placement Scaled(double factor) const { return {camera.Scaled(factor), camera_from_mesh}; }
};

/// The matrix of the cross product: CrossOf(v) * x = v x x.
Eigen::Matrix3d CrossOf(const Eigen::Vector3d& v);

/// Derivatives of a pixel, exact for the whole lens model.
struct PixelDerivatives {
  Eigen::Matrix<double, 2, 3> by_point;  ///< in the camera's frame
  Eigen::Vector2d by_log_focal, by_k1;
};
PixelDerivatives DerivativesAt(const Camera& camera, const Eigen::Vector3d& x_in_camera);

/// Unknowns: a turn about the mesh's centre [rad, in the camera's frame], its shift in units of the
/// mesh's radius, log of the focal length, k1, by how much mattes lie outside of the figure all
/// round [px], the lens's centre [px]. The centre is never solved: it is there so that Deviation
/// can say how well pictures would show it.
constexpr int kUnknowns = 11, kLogFocal = 6, kK1 = 7, kMatteOffset = 8, kCenterX = 9, kCenterY = 10;
using Step = Eigen::Matrix<double, kUnknowns, 1>;
using StepMatrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;

/// The weighted squares of many residuals, linear around one placement.
class NormalEquations {
 public:
  /// @param center, radius  of the mesh, in its own frame
  NormalEquations(const Placement& at, const Eigen::Vector3d& center, double radius);

  /// The pixel of `x_in_mesh` should move by `distance_px` along `direction`.
  /// @param of_matte  a matte says so, which may lie beside the figure
  void Add(const Eigen::Vector3d& x_in_mesh, const Eigen::Vector2d& direction, double distance_px,
           double weight, bool of_matte = false);
  /// Unknown `i` should move by `distance`.
  void AddPrior(int i, double distance, double weight);
  void Add(const NormalEquations& other);

  double cost() const { return cost_; }  ///< sum of weight * distance^2
  const StepMatrix& matrix() const { return h_; }
  const Step& gradient() const { return g_; }  ///< the right-hand side
  const Placement& at() const { return at_; }

  /// The step of least squares.
  /// @param free_unknowns  one for each unknown; others stay
  /// @param damping  of the diagonal, relative
  Step Solve(const std::array<bool, kUnknowns>& free_unknowns, double damping) const;
  Placement Moved(const Step& step) const;

  /// Standard deviation of an unknown when the others in `free_unknowns` are solved too and weights
  /// are inverse variances; infinite when it is not determined.
  double Deviation(int i, const std::array<bool, kUnknowns>& free_unknowns) const;
  /// The least over the greatest eigenvalue of the turn's matrix when shift and lens are solved for
  /// each turn: 0 when some turn changes nothing, as for a body of revolution.
  /// @param axis  of the least determined turn, unit, in the camera's frame; may be null
  double TurnEigenvalueRatio(Eigen::Vector3d* axis = nullptr) const;

 private:
  Placement at_;
  Eigen::Vector3d center_in_camera_;
  Eigen::Matrix3d turn_;
  double radius_;
  StepMatrix h_ = StepMatrix::Zero();
  Step g_ = Step::Zero();
  double cost_ = 0;
};

/// The place, and what is said of the lens.
std::array<bool, kUnknowns> FreeUnknowns(bool focal, bool k1);

}  // namespace keypose::composite
