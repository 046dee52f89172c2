#include "motion/bvh_rig/rig_text.h"

#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/io/meshes/bone_weights.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::motion {

namespace {

using Json = nlohmann::json;

constexpr int kMostBones = 10000;

char FirstOf(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  return first == std::string::npos ? 0 : text[first];
}

Json ParsedJson(const std::string& text, const std::string& name) {
  RequireShallowJson(text, "animate: " + name);
  Json root = Json::parse(text, nullptr, false);
  if (!root.is_object()) throw InputError("animate: " + name + " is not JSON with an object");
  return root;
}

const Json& Member(const Json& json, const char* key, const std::string& what) {
  if (!json.is_object() || !json.contains(key)) throw InputError(what + " has no `" + key + "`");
  return json[key];
}

/// Bones sorted so that parents come first.
/// @param parents  names; "" for roots
std::vector<Bone> Sorted(std::vector<Bone> bones, const std::vector<std::string>& parents,
                         const std::string& name) {
  std::vector<Bone> sorted;
  std::map<std::string, int> place;
  std::vector<char> done(bones.size(), 0);
  for (bool grew = true; grew;) {
    grew = false;
    for (int b = 0; b < SizeOf(bones); ++b) {
      if (done[b]) continue;
      const auto parent = place.find(parents[b]);
      if (!parents[b].empty() && parent == place.end()) continue;
      bones[b].parent = parents[b].empty() ? -1 : parent->second;
      place[bones[b].name] = SizeOf(sorted);
      sorted.push_back(bones[b]);
      done[b] = 1;
      grew = true;
    }
  }
  for (int b = 0; b < SizeOf(bones); ++b)
    if (!done[b])
      throw InputError("animate: " + name + ": bone '" + bones[b].name + "' hangs on '" +
                       parents[b] + "', which is not a bone of the tree");
  return sorted;
}

/// The joints of a .mhskel: means of vertices.
Eigen::Vector3d JointOf(const Json& joints, const std::string& joint, const Mesh& mesh,
                        const std::string& name) {
  const std::string what = "animate: " + name + ": joint '" + joint + "'";
  if (!joints.contains(joint) || !joints[joint].is_array() || joints[joint].empty())
    throw InputError(what + " has no list of vertices");
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Json& vertex : joints[joint]) {
    if (!vertex.is_number_integer() || vertex < 0 || vertex >= mesh.vertex_count())
      throw InputError(what + " names vertex " + vertex.dump() + ", but the mesh has " +
                       std::to_string(mesh.vertex_count()) + "; it belongs to another mesh");
    sum += mesh.points.row(vertex.get<int>()).transpose();
  }
  return sum / static_cast<double>(joints[joint].size());
}

std::vector<Bone> BonesOfJson(const std::string& text, const Mesh& mesh, const std::string& name) {
  const Json root = ParsedJson(text, name);
  const std::string file = "animate: " + name;
  const Json &bones = Member(root, "bones", file), &joints = Member(root, "joints", file);
  std::vector<Bone> result;
  std::vector<std::string> parents;
  for (const auto& [bone_name, entry] : bones.items()) {
    const std::string what = file + ": bone '" + bone_name + "'";
    Bone bone{bone_name, -1, {}, {}};
    const Json &head = Member(entry, "head", what), &tail = Member(entry, "tail", what);
    if (!head.is_string() || !tail.is_string())
      throw InputError(what + " needs the names of joints in `head` and `tail`");
    bone.head = JointOf(joints, head, mesh, name);
    bone.tail = JointOf(joints, tail, mesh, name);
    const Json parent = entry.value("parent", Json());
    parents.push_back(parent.is_string() ? parent.get<std::string>() : "");
    result.push_back(bone);
  }
  return Sorted(std::move(result), parents, name);
}

/// A .tgf: joints, then edges. A bone turns about its first joint, as its parent's last.
std::vector<Bone> BonesOfGraph(const std::string& text, const std::string& name,
                               std::vector<std::string>& columns) {
  std::istringstream lines(text);
  std::map<int, Eigen::Vector3d> joints;
  std::vector<std::pair<int, int>> edges;
  int part = 0, number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::istringstream in(line);
    const std::string where = "animate: " + name + ", line " + std::to_string(number);
    if (FirstOf(line) == 0) continue;
    if (FirstOf(line) == '#') {
      ++part;
    } else if (part == 0) {
      int joint = 0;
      Eigen::Vector3d at;
      if (!(in >> joint >> at[0] >> at[1] >> at[2]) || !at.allFinite())
        throw InputError(where + ": a joint is `number x y z`");
      joints[joint] = at;
    } else if (part == 1) {
      int from = 0, to = 0;
      if (!(in >> from >> to) || !joints.count(from) || !joints.count(to))
        throw InputError(where + ": a bone is the numbers of two joints");
      edges.emplace_back(from, to);
    }
  }
  std::map<int, std::string> ends_at;  // the bone whose tail a joint is
  std::vector<Bone> bones;
  for (const auto& [from, to] : edges) {
    const std::string bone = std::to_string(from) + "-" + std::to_string(to);
    ends_at[to] = bone;
    columns.push_back(bone);
    bones.push_back({bone, -1, joints[from], joints[to]});
  }
  std::vector<std::string> parents;
  for (const auto& edge : edges) {
    const auto parent = ends_at.find(edge.first);
    parents.push_back(parent == ends_at.end() ? "" : parent->second);
  }
  return Sorted(std::move(bones), parents, name);
}

}  // namespace

RiggedMesh MakeRig(Mesh mesh, const std::string& skeleton, const std::string& skeleton_name,
                   const std::string& weights, const std::string& weights_name) {
  RiggedMesh rig;
  rig.mesh = std::move(mesh);
  std::vector<std::string> columns;
  rig.bones = FirstOf(skeleton) == '{' ? BonesOfJson(skeleton, rig.mesh, skeleton_name)
                                       : BonesOfGraph(skeleton, skeleton_name, columns);
  if (rig.bones.empty() || SizeOf(rig.bones) > kMostBones)
    throw InputError("animate: " + skeleton_name + " has " + std::to_string(rig.bones.size()) +
                     " bones; a skeleton was expected");
  if (columns.empty())
    for (const Bone& bone : rig.bones) columns.push_back(bone.name);
  rig.weights =
      ParseBoneWeights(weights, "animate: " + weights_name, columns, rig.mesh.vertex_count());
  for (auto& row : rig.weights)
    for (auto& term : row) term.first = rig.Find(columns[term.first]);
  for (auto& row : rig.weights) {
    double sum = 0;
    for (const auto& term : row) sum += term.second;
    if (sum > 0)
      for (auto& term : row) term.second /= sum;
    else
      row.clear();
  }
  return rig;
}

}  // namespace keypose::motion
