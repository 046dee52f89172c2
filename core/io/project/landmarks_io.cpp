#include "core/io/project/landmarks_io.h"

#include <fmt/format.h>
#include <algorithm>
#include <boost/property_tree/ptree.hpp>
#include <boost/property_tree/xml_parser.hpp>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "core/io/project/binding_io.h"
#include "core/io/text/files.h"
#include "core/io/text/json_pick.h"
#include "core/io/text/text_file.h"
#include "core/io/text/xml_depth.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/coordinate_limit.h"
#include "core/values/errors.h"

namespace keypose {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr double kClickedOn = 1e-4;  // of the diagonal; allows for rounding of numbers in the file
// limit on the median distance of points that were clicked on a slightly different version
constexpr double kMostSnap = 0.005;
constexpr double kFurthestSnap = 0.02;  // limit for each point

void RequireUniqueNames(const std::vector<Landmark>& landmarks, const fs::path& path) {
  std::set<std::string> names;
  for (const Landmark& landmark : landmarks)
    if (!names.insert(landmark.name).second)
      throw InputError(fmt::format("{}: landmark '{}' is there twice; rename or delete one",
                                   path.string(), landmark.name));
}

void RequireOnMesh(const Landmark& landmark, const Mesh& mesh, const fs::path& path) {
  if (landmark.face < 0 || landmark.face >= mesh.face_count())
    throw InputError(
        fmt::format("{}: landmark '{}' is on face {}, but the mesh has {} faces; it was picked on "
                    "another mesh: pick it again, or pass that mesh",
                    path.string(), landmark.name, landmark.face, mesh.face_count()));
  if (!IsInTriangle(landmark.barycentric))
    throw InputError(
        fmt::format("{}: landmark '{}' has barycentric coordinates that do not lie in its "
                    "triangle; pick it again",
                    path.string(), landmark.name));
}

/// A vertex as a landmark: the corner of the first face that uses it.
class VertexLandmarks {
 public:
  explicit VertexLandmarks(const Mesh& mesh)
      : first_face_(static_cast<std::size_t>(mesh.vertex_count()), {-1, 0}) {
    for (Eigen::Index f = mesh.faces.rows() - 1; f >= 0; --f)
      for (int k = 0; k < 3; ++k) first_face_[mesh.faces(f, k)] = {static_cast<int>(f), k};
  }
  Landmark At(long vertex, const std::string& name, const std::string& where,
              const char* which) const {
    if (vertex < 0 || vertex >= static_cast<long>(first_face_.size()))
      throw InputError(
          fmt::format("{}: {} vertex {} does not exist, the {} has {} vertices; the pairs were "
                      "picked on another mesh: pick them again",
                      where, which, vertex, which, first_face_.size()));
    const auto [face, corner] = first_face_[vertex];
    if (face < 0)
      throw InputError(fmt::format(
          "{}: {} vertex {} belongs to no face, so it cannot be a landmark", where, which, vertex));
    Landmark landmark;
    landmark.name = name;
    landmark.face = face;
    landmark.barycentric(corner) = 1;
    return landmark;
  }

 private:
  std::vector<std::pair<int, int>> first_face_;
};

std::vector<LandmarkPair> ReadVertexPairs(const fs::path& path, const Mesh& source,
                                          const Mesh& target) {
  const VertexLandmarks on_source(source), on_target(target);
  std::istringstream in(ReadTextFile(path));
  std::vector<LandmarkPair> pairs;
  std::map<long, int> line_of_source;
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (const auto hash = line.find('#'); hash != std::string::npos) line.resize(hash);
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    std::istringstream words(line);
    long s = 0, t = 0;
    std::string rest;
    const std::string where = fmt::format("{}:{}", path.string(), number);
    if (!(words >> s >> t) || (words >> rest))
      throw InputError(
          where + ": a line must hold 'source_vertex target_vertex', two whole numbers from 0");
    if (const auto [it, is_new] = line_of_source.emplace(s, number); !is_new)
      throw InputError(fmt::format("{}: source vertex {} is in line {} already; delete one", where,
                                   s, it->second));
    const std::string name = fmt::format("{}-{}", s, t);
    pairs.push_back(
        {name, on_source.At(s, name, where, "source"), on_target.At(t, name, where, "target")});
  }
  if (pairs.empty()) throw InputError(path.string() + " holds no landmark");
  return pairs;
}

json PickJson(const Landmark& landmark, const SurfacePlaces& places) {
  const Eigen::Vector3d& b = landmark.barycentric;
  json pick = {{"face", landmark.face}, {"barycentric", {b[0], b[1], b[2]}}};
  AddPlace(places.At(landmark.face, b), pick);
  return pick;
}

/// @return nothing when the pick was lost: it is not needed, or FollowPicks::Finish will name it
std::optional<Landmark> PickFrom(const json& pick, const std::string& name, const Mesh& mesh,
                                 const fs::path& path, FollowPicks& follow, bool needed = true) {
  Landmark landmark;
  landmark.name = name;
  if (follow.AsWritten()) {
    landmark.face = pick.at("face");
    for (int k = 0; k < 3; ++k)
      landmark.barycentric(k) = pick.at("barycentric").at(static_cast<std::size_t>(k));
    RequireOnMesh(landmark, mesh, path);
    return landmark;
  }
  const CarriedPlace carried = follow.Carry(name, PlaceFrom(pick), needed);
  if (carried.grade == CarriedPlace::Grade::kLost) return std::nullopt;
  landmark.face = carried.face;
  landmark.barycentric = carried.barycentric;
  return landmark;
}

MeshBinding BindingIn(const json& root, const char* side, const fs::path& path) {
  return BindingFrom(root.contains(side) ? root[side] : json::object(), path);
}

std::vector<LandmarkPair> PairsFrom(const json& root, const fs::path& path, const Mesh& source,
                                    const Mesh& target, CarryLog* log) {
  FollowPicks on_source(BindingIn(root, "source", path), source, path.string(), "source");
  FollowPicks on_target(BindingIn(root, "target", path), target, path.string(), "target");
  std::vector<LandmarkPair> pairs;
  std::set<std::string> names;
  int dropped = 0;
  for (const json& entry : root.at("pairs")) {
    LandmarkPair pair;
    pair.name = entry.at("name");
    if (!names.insert(pair.name).second)
      throw InputError(fmt::format("{}: landmark '{}' is there twice; rename or delete one",
                                   path.string(), pair.name));
    pair.confirmed = entry.value("confirmed", true);
    pair.confidence = entry.value("confidence", 1.0);
    pair.origin = entry.value("origin", "");
    const auto from =
        PickFrom(entry.at("source"), pair.name, source, path, on_source, pair.confirmed);
    const auto to =
        PickFrom(entry.at("target"), pair.name, target, path, on_target, pair.confirmed);
    if (!from || !to) {
      dropped += !pair.confirmed;
      continue;
    }
    pair.source = *from;
    pair.target = *to;
    pairs.push_back(std::move(pair));
  }
  on_source.Finish(log);
  on_target.Finish(log);
  const std::string fact = path.string() + ": " + std::to_string(dropped) +
                           " unconfirmed suggestions could not follow to the rebuilt mesh";
  if (dropped > 0 && pairs.empty()) throw InputError(fact + "; make them anew on that mesh");
  if (dropped > 0 && log) log->warnings.push_back(fact + " and are left out");
  return pairs;
}

std::vector<LandmarkPair> ReadJsonPairs(const fs::path& path, const std::string& text,
                                        const Mesh& source, const Mesh& target, CarryLog* log) {
  std::vector<LandmarkPair> pairs;
  RequireShallowJson(text, path.string());
  try {
    const json root = json::parse(text);
    if (!root.contains("pairs") && root.contains("landmarks"))
      throw InputError(
          path.string() +
          " holds the picks of one mesh; give the other mesh's picks as a second file");
    pairs = PairsFrom(root, path, source, target, log);
  } catch (const json::exception& error) {
    throw InputError(path.string() + " is not a file of landmark pairs: " + JsonFault(error));
  }
  if (pairs.empty()) throw InputError(path.string() + " holds no landmark");
  return pairs;
}

/// Checks that clicked points lie on the mesh. Points beside it were clicked on another mesh.
void JudgeSnaps(std::vector<double> off, const fs::path& path, const std::string& side,
                CarryLog* log) {
  if (off.empty()) return;
  std::sort(off.begin(), off.end());
  const double median = off[off.size() / 2], furthest = off.back();
  if (furthest < kClickedOn) return;
  const std::string how = fmt::format(
      "{}: its points do not lie on the {}: half of them are {:.2f} % of its diagonal or more "
      "away, one {:.2f} %",
      path.string(), side, 100 * median, 100 * furthest);
  if (median > kMostSnap)
    throw InputError(how +
                     fmt::format("; they were picked on another mesh: pick them again. Or, while "
                                 "you still have that mesh: keypose "
                                 "landmarks bind --mesh THAT_MESH --picks {} --bound FILE.json",
                                 path.string()));
  if (log)
    log->warnings.push_back(how + fmt::format("; the nearest places are used. If the {} was "
                                              "rebuilt since then, check them, or pick again",
                                              side));
}

std::vector<Landmark> ReadPickedPoints(const fs::path& path, const Mesh& mesh, CarryLog* log,
                                       const std::string& side) {
  boost::property_tree::ptree tree;
  std::string text = ReadTextFile(path);
  RequireShallowXml(text, path.string() + " is not a MeshLab picked-points file");
  std::istringstream in(std::move(text));
  try {
    boost::property_tree::read_xml(in, tree);
  } catch (const boost::property_tree::xml_parser_error& error) {
    throw InputError(fmt::format("{}:{}: not a MeshLab picked-points file: {}", path.string(),
                                 error.line(), error.message()));
  }
  const auto picked = tree.get_child_optional("PickedPoints");
  if (!picked)
    throw InputError(path.string() +
                     " is not a MeshLab picked-points file: it has no element PickedPoints; save "
                     "the points from MeshLab again");
  const RayScene scene(mesh.points, mesh.faces);
  const double diagonal = BoundingDiagonal(mesh.points);
  std::vector<double> off;
  std::vector<Landmark> landmarks;
  for (const auto& [tag, node] : *picked) {
    if (tag != "point" || node.get<int>("<xmlattr>.active", 1) == 0) continue;
    Landmark landmark;
    landmark.name = node.get<std::string>("<xmlattr>.name", "");
    const Eigen::Vector3d position(node.get<double>("<xmlattr>.x", NAN),
                                   node.get<double>("<xmlattr>.y", NAN),
                                   node.get<double>("<xmlattr>.z", NAN));
    if (!position.allFinite() || position.cwiseAbs().maxCoeff() > kMostCoordinate)
      throw InputError(
          fmt::format("{}: point '{}' has no usable x, y, z", path.string(), landmark.name));
    const RayScene::Foot foot = scene.ClosestPoint(position);
    off.push_back(std::sqrt(foot.squared_distance) / diagonal);
    if (off.back() > kFurthestSnap)
      throw InputError(
          fmt::format("{}: landmark '{}' is {:.3g} away from the mesh, more than 2 % of its "
                      "diagonal; it was picked on another mesh: pick it again",
                      path.string(), landmark.name, std::sqrt(foot.squared_distance)));
    landmark.face = foot.face;
    landmark.barycentric = foot.barycentric;
    landmarks.push_back(landmark);
  }
  RequireUniqueNames(landmarks, path);
  JudgeSnaps(std::move(off), path, side, log);
  return landmarks;
}

bool HasPhotoPicksOnly(const json& root) {
  return root.is_object() && root.contains("pixels") && !root.contains("landmarks");
}

/// The first character that is not a space; 0 in a file without one.
char FirstLetterOf(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  return first == std::string::npos ? 0 : text[first];
}

/// Wrap's points are lists of three numbers; our files have named fields.
bool IsWrapPoint(const json& value) {
  return value.is_array() && value.size() == 3 &&
         std::all_of(value.begin(), value.end(), [](const json& one) { return one.is_number(); });
}

bool HoldsWrapPoints(const std::string& text) {
  if (!IsShallowJson(text)) return false;
  const json root = json::parse(text, nullptr, false);
  return !root.is_discarded() && root.is_structured() && !root.empty() &&
         IsWrapPoint(*root.begin());
}

Landmark WrapPoint(const std::string& name, const json& value, const Mesh& mesh,
                   const fs::path& path) {
  if (!IsWrapPoint(value))
    throw InputError(
        fmt::format("{}: landmark '{}' is not [face, u, v]; write the points from Wrap again",
                    path.string(), name));
  const double face = value[0], u = value[1], v = value[2];
  const bool is_index = face >= 0 && face < mesh.face_count() && face == std::floor(face);
  const Landmark landmark{name, is_index ? static_cast<int>(face) : -1, {u, v, 1 - u - v}};
  RequireOnMesh(landmark, mesh, path);
  return landmark;
}

std::vector<Landmark> ReadWrapPoints(const std::string& text, const fs::path& path,
                                     const Mesh& mesh, CarryLog* log, const std::string& side) {
  const json root = json::parse(text);
  std::vector<Landmark> landmarks;
  if (root.is_object())
    for (const auto& [name, value] : root.items())
      landmarks.push_back(WrapPoint(name, value, mesh, path));
  else
    for (const json& value : root)
      landmarks.push_back(WrapPoint(std::to_string(landmarks.size() + 1), value, mesh, path));
  if (log) {
    log->unbound = true;
    log->warnings.push_back(
        fmt::format("{} does not say on which mesh it was picked; its face numbers are used "
                    "unchanged, which is wrong if the {} was rebuilt since then. Bind it to the "
                    "mesh: keypose landmarks bind --help",
                    path.string(), side));
  }
  return landmarks;
}

}  // namespace

std::vector<Landmark> ReadPicks(const fs::path& path, const Mesh& mesh, CarryLog* log,
                                const std::string& side) {
  const std::string text = ReadTextFile(path);
  if (FirstLetterOf(text) == '<') return ReadPickedPoints(path, mesh, log, side);
  if (HoldsWrapPoints(text)) return ReadWrapPoints(text, path, mesh, log, side);
  return ReadLandmarks(path, mesh, log, side);
}

std::vector<Landmark> ReadLandmarks(const fs::path& path, const Mesh& mesh, CarryLog* log,
                                    const std::string& side) {
  std::vector<Landmark> landmarks;
  const std::string text = ReadTextFile(path);
  RequireShallowJson(text, path.string());
  try {
    const json root = json::parse(text);
    if (HasPhotoPicksOnly(root))
      throw InputError(path.string() +
                       " holds picks in photographs, and none on a mesh; pick in another file");
    FollowPicks follow(BindingIn(root, "mesh", path), mesh, path.string(), side);
    for (const json& entry : root.at("landmarks"))
      if (auto landmark = PickFrom(entry, entry.at("name"), mesh, path, follow))
        landmarks.push_back(std::move(*landmark));
    follow.Finish(log);
  } catch (const json::exception& error) {
    throw InputError(path.string() + " is not a landmarks file: " + JsonFault(error));
  }
  RequireUniqueNames(landmarks, path);
  return landmarks;
}

std::string PickedPointsText(const std::vector<Landmark>& landmarks, const Mesh& mesh) {
  boost::property_tree::ptree tree;
  boost::property_tree::ptree& points = tree.put("PickedPoints", "");
  for (const Landmark& landmark : landmarks) {
    const Eigen::Vector3d place = PositionOf(landmark, mesh);
    boost::property_tree::ptree& point = points.add("point", "");
    point.put("<xmlattr>.name", landmark.name);
    point.put("<xmlattr>.active", 1);
    for (int k = 0; k < 3; ++k)
      point.put(fmt::format("<xmlattr>.{}", "xyz"[k]), fmt::format("{}", place[k]));
  }
  std::ostringstream out;
  boost::property_tree::write_xml(out, tree);
  return out.str();
}

std::string WrapPointsText(const std::vector<Landmark>& landmarks) {
  json points = json::object();
  for (const Landmark& landmark : landmarks)
    points[landmark.name] = {landmark.face, landmark.barycentric[0], landmark.barycentric[1]};
  return points.dump(1) + "\n";
}

bool HoldsPhotoPicksOnly(const fs::path& path) {
  const std::string text = ReadTextFile(path);
  return IsShallowJson(text) && HasPhotoPicksOnly(json::parse(text, nullptr, false));
}

void WriteLandmarks(const fs::path& path, const Mesh& mesh,
                    const std::vector<Landmark>& landmarks) {
  const SurfacePlaces places(mesh);
  json root;
  root["schema"] = 2;
  root["mesh"] = BindingJson<json>(BindTo(mesh));
  root["landmarks"] = json::array();
  for (const Landmark& landmark : landmarks) {
    json pick = PickJson(landmark, places);
    pick["name"] = landmark.name;
    root["landmarks"].push_back(std::move(pick));
  }
  WriteFileAtomically(path, root.dump(1) + "\n");
}

void WriteLandmarkPairs(const fs::path& path, const Mesh& source, const Mesh& target,
                        const std::vector<LandmarkPair>& pairs) {
  const SurfacePlaces on_source(source), on_target(target);
  json root;
  root["schema"] = 2;
  root["source"] = BindingJson<json>(BindTo(source));
  root["target"] = BindingJson<json>(BindTo(target));
  root["pairs"] = json::array();
  for (const LandmarkPair& pair : pairs)
    root["pairs"].push_back({{"name", pair.name},
                             {"source", PickJson(pair.source, on_source)},
                             {"target", PickJson(pair.target, on_target)},
                             {"confidence", pair.confidence},
                             {"origin", pair.origin},
                             {"confirmed", pair.confirmed}});
  WriteFileAtomically(path, root.dump(1) + "\n");
}

std::vector<LandmarkPair> ReadLandmarkPairs(const std::vector<fs::path>& paths, const Mesh& source,
                                            const Mesh& target, CarryLog* log) {
  if (paths.empty()) return {};
  if (paths.size() == 1) {
    const std::string text = ReadTextFile(paths[0]);
    if (HoldsWrapPoints(text))
      throw InputError(
          paths[0].string() +
          " holds the picks of one mesh; give the other mesh's picks as a second file");
    if (FirstLetterOf(text) == '{') return ReadJsonPairs(paths[0], text, source, target, log);
    if (log) {
      log->unbound = true;
      log->warnings.push_back(paths[0].string() +
                              " does not say on which meshes it was picked; its vertex numbers are "
                              "used unchanged, which is wrong if one of the two was rebuilt since "
                              "then. Bind it to them: keypose landmarks bind --help");
    }
    return ReadVertexPairs(paths[0], source, target);
  }
  if (paths.size() > 2)
    throw InputError(
        "landmarks: give one file of pairs, or the source's picks and the target's; not " +
        std::to_string(paths.size()) + " files");
  const auto on_source = ReadPicks(paths[0], source, log, "source"),
             on_target = ReadPicks(paths[1], target, log, "target");
  std::map<std::string, Landmark> by_name;
  for (const Landmark& landmark : on_target) by_name[landmark.name] = landmark;
  std::vector<LandmarkPair> pairs;
  for (const Landmark& landmark : on_source)
    if (const auto it = by_name.find(landmark.name); it != by_name.end())
      pairs.push_back({landmark.name, landmark, it->second});
  if (pairs.empty())
    throw InputError(fmt::format(
        "{} and {} share no landmark name; give the same spot of clay the same name on both poses",
        paths[0].string(), paths[1].string()));
  return pairs;
}

Eigen::Vector3d PositionOf(const Landmark& landmark, const Mesh& mesh) {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k)
    position += landmark.barycentric(k) * mesh.points.row(mesh.faces(landmark.face, k)).transpose();
  return position;
}

}  // namespace keypose
