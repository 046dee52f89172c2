// What a person did to a mesh with the brush that mends.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace keypose {

enum class MendTool {
  kSmooth,  ///< bumps narrower than the brush fade
  kPull,    ///< the surface moves along its normal
  kFill,    ///< a smooth patch from the rim takes the place of what is under the brush
};

/// A path of the brush. Places are on the mesh as it came: mending moves vertices and keeps faces,
/// so a place is found again after every earlier stroke.
struct MendStroke {
  struct Place {
    int face = -1;
    Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();
  };
  MendTool tool = MendTool::kSmooth;
  double radius = 0;    ///< of the brush, in the mesh's unit; > 0
  double strength = 1;  ///< 0 to 1; of kPull -1 (in) to 1 (out by the radius)
  std::vector<Place> places;
};

/// "smooth", "pull", "fill"
inline std::string NameOf(MendTool tool) {
  return tool == MendTool::kSmooth ? "smooth" : tool == MendTool::kPull ? "pull" : "fill";
}
inline std::optional<MendTool> MendToolNamed(std::string_view name) {
  for (const MendTool tool : {MendTool::kSmooth, MendTool::kPull, MendTool::kFill})
    if (name == NameOf(tool)) return tool;
  return std::nullopt;
}

}  // namespace keypose
