#include "core/io/project/rig_parts.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/io/project/lens_use.h"
#include "core/values/errors.h"

namespace keypose {

Eigen::Quaterniond ExactRotation(const Eigen::Matrix3d& r, const std::string& where) {
  const double off = (r * r.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!r.allFinite() || !(off < 1e-2) || r.determinant() < 0)
    throw InputError(
        fmt::format("{}: its rotation is none (off by {:.3g}); three orthogonal rows "
                    "of length 1 are needed, from world to camera",
                    where, off));
  return Eigen::Quaterniond(r).normalized();
}

Eigen::Matrix3d RotationOf(const std::vector<double>& n, const std::string& where) {
  if (n.size() == 9)
    return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(n.data());
  if (n.size() != 3)
    throw InputError(where + ": `rotation` must hold 9 numbers, or 3 (Rodrigues); it has " +
                     std::to_string(n.size()));
  const Eigen::Vector3d turn(n[0], n[1], n[2]);
  if (turn.norm() < 1e-12) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
}

void RequireUsable(const View& view, const std::string& where) {
  Camera sized = view.camera;
  if (sized.width == 0 || sized.height == 0) sized.width = sized.height = 1;
  RequireUsableCamera(sized, where);
  if (!view.camera_from_world.translation.allFinite())
    throw InputError(where + ": its place is not finite");
}

int SideOf(double pixels) {
  constexpr double kMost = 1e9;
  return std::isnan(pixels) ? -1 : static_cast<int>(std::round(std::clamp(pixels, -1.0, kMost)));
}

void RequireUpperTriangle(const double* k, const std::string& where) {
  constexpr double kRounding = 1e-9;
  for (const int zero : {3, 6, 7})
    if (!(std::abs(k[zero]) <= kRounding))
      throw InputError(where + ": the rows of its K must be fx, skew, cx; 0, fy, cy; 0, 0, 1");
  if (!(std::abs(k[8] - 1) <= kRounding))
    throw InputError(where + ": the last number of its K must be 1; divide all nine by it");
}

}  // namespace keypose
