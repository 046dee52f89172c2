// Numbers of the matrices in OpenCV's YAML. Only .cpp files of this room include it, and yaml-cpp.
#pragma once

#include <yaml-cpp/yaml.h>

#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace keypose {

/// The first of the names that the map has; undefined: none.
YAML::Node FirstOf(const YAML::Node& node, const std::vector<const char*>& names);

/// All numbers of a matrix node ({rows, cols, dt, data}) or of nested lists, in order.
/// @throws YAML::RepresentationException  more lists or numbers than a matrix has; no number
std::vector<double> YamlNumbers(const YAML::Node& node);

/// @throws InputError  neither 9 numbers nor 3 (Rodrigues)
Eigen::Matrix3d RotationOf(const std::vector<double>& numbers, const std::string& where);

}  // namespace keypose
