#include "core/io/project/yaml_numbers.h"

#include "core/values/errors.h"

namespace keypose {
namespace {

/// @param left  how many nodes may follow: an alias (*name) can contain itself, and a few of them
/// can stand for more numbers than fit in memory
void Collect(const YAML::Node& node, int depth, int* left, std::vector<double>* numbers) {
  constexpr int kDeepest = 8;
  if (depth > kDeepest || --*left < 0)
    throw YAML::RepresentationException(node.Mark(), "more lists or numbers than any matrix has");
  if (node.IsMap() && node["data"]) return Collect(node["data"], depth + 1, left, numbers);
  if (node.IsScalar()) return numbers->push_back(node.as<double>());
  for (const YAML::Node& part : node) Collect(part, depth + 1, left, numbers);
}

}  // namespace

YAML::Node FirstOf(const YAML::Node& node, const std::vector<const char*>& names) {
  for (const char* name : names)
    if (node[name]) return node[name];
  return YAML::Node(YAML::NodeType::Undefined);
}

std::vector<double> YamlNumbers(const YAML::Node& node) {
  int left = 1000;
  std::vector<double> numbers;
  if (node && !node.IsNull()) Collect(node, 0, &left, &numbers);
  return numbers;
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

}  // namespace keypose
