#include "armature/skinning/weights_text.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/errors.h"
#include "core/io/files.h"
#include "core/size_of.h"

namespace keypose::armature {

namespace {

using Json = nlohmann::json;

int FindName(const std::vector<std::string>& names, const std::string& name) {
  for (int n = 0; n < SizeOf(names); ++n)
    if (names[n] == name) return n;
  return -1;
}

void AddList(const Json& list, const std::string& where, int bone, Eigen::MatrixXd& dense) {
  if (!list.is_array()) throw InputError(where + " are not a list");
  for (const Json& pair : list) {
    const bool fine = pair.is_array() && pair.size() == 2 && pair[0].is_number_integer() &&
                      pair[1].is_number() && pair[0] >= 0 && pair[0] < dense.rows();
    if (!fine || !std::isfinite(pair[1].get<double>()) || pair[1].get<double>() < 0)
      throw InputError(where + " hold " + pair.dump() + "; a vertex of the mesh, which has " +
                       std::to_string(dense.rows()) + ", and a number from 0 were expected");
    dense(pair[0].get<Eigen::Index>(), bone) += pair[1].get<double>();
  }
}

void TakeJson(const std::string& text, const std::string& file,
              const std::vector<std::string>& names, Eigen::MatrixXd& dense) {
  RequireShallowJson(text, "armature: " + file);
  const Json root = Json::parse(text, nullptr, false);
  if (!root.is_object() || !root.contains("weights") || !root["weights"].is_object())
    throw InputError("armature: " + file + " is not JSON with an object `weights`");
  for (const auto& [name, list] : root["weights"].items()) {
    const std::string where = "armature: " + file + ": the weights of '" + name + "'";
    const int bone = FindName(names, name);
    if (bone < 0)
      throw InputError(where + " are those of no joint of the skeleton; did you mean '" +
                       NearestWord(name, names) + "'?");
    AddList(list, where, bone, dense);
  }
}

void TakeMatrix(const std::string& text, const std::string& file, Eigen::MatrixXd& dense) {
  std::istringstream in(text);
  long columns = 0, rows = 0;
  if (!(in >> columns >> rows) || columns != dense.cols() || rows != dense.rows())
    throw InputError("armature: " + file + " has " + std::to_string(columns) + " columns and " +
                     std::to_string(rows) + " rows; one column for each of the " +
                     std::to_string(dense.cols()) + " joints and one row for each of the " +
                     std::to_string(dense.rows()) + " vertices were expected");
  for (long c = 0; c < columns; ++c)
    for (long r = 0; r < rows; ++r)
      if (!(in >> dense(r, c)) || !std::isfinite(dense(r, c)))
        throw InputError("armature: " + file + " ends, or is not a number, at column " +
                         std::to_string(c) + ", row " + std::to_string(r));
}

}  // namespace

SkinWeights ParseWeights(const std::string& text, const std::string& file,
                         const std::vector<std::string>& names, const std::vector<int>& bone_of,
                         int vertex_count) {
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(vertex_count, SizeOf(names));
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first != std::string::npos && text[first] == '{')
    TakeJson(text, file, names, dense);
  else
    TakeMatrix(text, file, dense);
  for (Eigen::Index v = 0; v < dense.rows(); ++v)
    if (!(dense.row(v).maxCoeff() > 0))
      throw InputError("armature: " + file + ": no bone moves vertex " + std::to_string(v) +
                       " of the mesh; give it a weight, or leave --weights out to have all weights "
                       "computed");
  const int bones = *std::max_element(bone_of.begin(), bone_of.end()) + 1;
  Eigen::MatrixXd of_bones = Eigen::MatrixXd::Zero(vertex_count, bones);
  for (int n = 0; n < SizeOf(names); ++n) of_bones.col(bone_of[n]) += dense.col(n);
  return Pruned(of_bones);
}

}  // namespace keypose::armature
