#include "core/io/meshes/bone_weights.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose {

namespace {

constexpr double kRounding = 1e-6;

bool IsWeight(double weight) { return std::isfinite(weight) && weight >= -kRounding; }

void AddWeight(int bone, double weight, std::vector<std::pair<int, double>>& of_vertex) {
  if (weight > 0) of_vertex.emplace_back(bone, weight);
}

void AddList(const nlohmann::json& list, const std::string& where, int bone, BoneWeights& weights) {
  if (!list.is_array()) throw InputError(where + " are not a list");
  for (const nlohmann::json& pair : list) {
    const bool fine = pair.is_array() && pair.size() == 2 && pair[0].is_number_integer() &&
                      pair[1].is_number() && pair[0] >= 0 && pair[0] < SizeOf(weights);
    if (!fine || !IsWeight(pair[1]))
      throw InputError(where + " hold " + pair.dump() + "; a vertex of the mesh, which has " +
                       std::to_string(weights.size()) + ", and a number from 0 were expected");
    AddWeight(bone, pair[1], weights[pair[0].get<std::size_t>()]);
  }
}

void TakeJson(const std::string& text, const std::string& file,
              const std::vector<std::string>& names, BoneWeights& weights) {
  RequireShallowJson(text, file);
  const nlohmann::json root = nlohmann::json::parse(text, nullptr, false);
  if (!root.is_object() || !root.contains("weights") || !root["weights"].is_object())
    throw InputError(file + " is not JSON with an object `weights`");
  for (const auto& [name, list] : root["weights"].items()) {
    const std::string where = file + ": the weights of '" + name + "'";
    const auto bone = std::find(names.begin(), names.end(), name);
    if (bone == names.end())
      throw InputError(where + " are those of no bone of the skeleton; did you mean '" +
                       NearestWord(name, names) + "'?");
    AddList(list, where, static_cast<int>(bone - names.begin()), weights);
  }
}

void TakeMatrix(const std::string& text, const std::string& file, int bones, BoneWeights& weights) {
  std::istringstream in(text);
  long columns = 0, rows = 0;
  if (!(in >> columns >> rows) || columns != bones || rows != SizeOf(weights))
    throw InputError(file + " has " + std::to_string(columns) + " columns and " +
                     std::to_string(rows) + " rows; one column for each of the " +
                     std::to_string(bones) + " bones and one row for each of the " +
                     std::to_string(weights.size()) + " vertices were expected");
  for (int bone = 0; bone < bones; ++bone)
    for (int vertex = 0; vertex < SizeOf(weights); ++vertex) {
      double weight = 0;
      if (!(in >> weight) || !IsWeight(weight))
        throw InputError(file + " ends, or has no number from 0, at column " +
                         std::to_string(bone) + ", row " + std::to_string(vertex));
      AddWeight(bone, weight, weights[vertex]);
    }
}

}  // namespace

BoneWeights ParseBoneWeights(const std::string& text, const std::string& file,
                             const std::vector<std::string>& names, int vertex_count) {
  BoneWeights weights(vertex_count);
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first != std::string::npos && text[first] == '{')
    TakeJson(text, file, names, weights);
  else
    TakeMatrix(text, file, SizeOf(names), weights);
  return weights;
}

}  // namespace keypose
