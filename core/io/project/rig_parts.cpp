#include "core/io/project/rig_parts.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/io/project/poses_io.h"
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

}  // namespace keypose
