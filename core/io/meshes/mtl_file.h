// Wavefront MTL: the colour and the colour texture of each material.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace keypose {

/// A texture with the options that stand before its name.
struct MtlMap {
  std::string file;                                  ///< as it is written; empty: none
  Eigen::Vector2d scale = Eigen::Vector2d::Ones();   ///< -s; u v become scale u v + offset
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();  ///< -o
  bool clamped = false;                              ///< -clamp on
  std::vector<std::string> left_out;                 ///< options that change its colours: -mm, -t
};

struct MtlMaterial {
  std::string name;
  std::optional<Eigen::Vector3d> color;  ///< Kd, as levels from 0 to 1
  /// map_Kd; where there is none, map_basecolor and the like, map_Ka, map_Ke
  MtlMap map;
  /// Statements that are no colour here: `Kd spectral`, `Kd xyz`.
  std::vector<std::string> left_out;
};

/// Reads the text of an MTL. Keywords may be of any case. Unknown keywords are skipped.
/// Names by which programs call the colour texture: map_Kd, map_diffuse, map_basecolor,
/// map_base_color, map_albedo, map_color.
std::vector<MtlMaterial> ParseMtl(std::string_view text);

/// The texture and its options, of what stands behind `map_Kd`.
MtlMap ParseMtlMap(std::string_view text);

}  // namespace keypose
