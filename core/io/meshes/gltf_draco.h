// Meshes that were packed by Draco, as glTF keeps them.
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <string_view>

namespace keypose {

struct DracoMesh {
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  std::map<std::string, Rows> attributes;  ///< V x components
  Rows corners;                            ///< 3 F x 1
};

/// @param ids         Draco's unique id of each attribute
/// @param normalized  whether its integers stand for fractions of their largest one
/// @return what is wrong; empty: nothing
std::string UnpackDraco(std::string_view bytes, const std::map<std::string, int>& ids,
                        const std::map<std::string, bool>& normalized, DracoMesh* mesh);

}  // namespace keypose
