#include "core/io/project/stiffness_map.h"

#include <cmath>
#include <iterator>
#include <sstream>
#include <vector>

#include "core/values/errors.h"

namespace keypose {

namespace {

void CheckCount(Eigen::Index count, int vertex_count, const std::string& name) {
  if (count != vertex_count)
    throw InputError("register: " + name + " has " + std::to_string(count) +
                     " stiffness values, but the source has " + std::to_string(vertex_count) +
                     " vertices; paint it on the source mesh");
}

}  // namespace

Eigen::VectorXd ParseStiffness(const std::string& text, int vertex_count, const std::string& name) {
  std::vector<double> values;
  std::istringstream lines(text);
  std::string line, word;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::istringstream words(line.substr(0, line.find('#')));
    while (words >> word) {
      std::size_t used = 0;
      double value = 0;
      try {
        value = std::stod(word, &used);
      } catch (const std::exception&) {
        used = 0;
      }
      if (used != word.size() || !std::isfinite(value) || value <= 0)
        throw InputError(name + ":" + std::to_string(number) + ": '" + word +
                         "' is not a stiffness; write one positive number for each vertex");
      values.push_back(value);
    }
  }
  CheckCount(std::ssize(values), vertex_count, name);
  return Eigen::Map<const Eigen::VectorXd>(values.data(), std::ssize(values));
}

Eigen::VectorXd StiffnessFromColors(const Mesh& painted, int vertex_count,
                                    const std::string& name) {
  if (painted.colors.rows() == 0)
    throw InputError("register: " + name +
                     " has no vertex colours; paint greys, or pass a text file of numbers");
  CheckCount(painted.colors.rows(), vertex_count, name);
  const Eigen::VectorXd luma = painted.colors.cast<double>() * Eigen::Vector3d(0.299, 0.587, 0.114);
  return luma.unaryExpr([](double y) { return std::pow(8.0, y / 127.5 - 1.0); });
}

}  // namespace keypose
