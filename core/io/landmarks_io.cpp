#include "core/io/landmarks_io.h"

#include <fmt/format.h>
#include <algorithm>
#include <boost/property_tree/ptree.hpp>
#include <boost/property_tree/xml_parser.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "core/errors.h"
#include "core/geometry.h"
#include "core/io/files.h"
#include "core/ray_scene.h"

namespace keypose {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

std::string SignatureOf(const Mesh& mesh) { return fmt::format("{} vertices, {} faces", mesh.vertex_count(), mesh.face_count()); }

void RequireUniqueNames(const std::vector<Landmark>& landmarks, const fs::path& path) {
  std::set<std::string> names;
  for (const Landmark& landmark : landmarks)
    if (!names.insert(landmark.name).second)
      throw InputError(fmt::format("{}: landmark '{}' is there twice; rename or delete one", path.string(), landmark.name));
}

void RequireOnMesh(const Landmark& landmark, const Mesh& mesh, const fs::path& path) {
  if (landmark.face < 0 || landmark.face >= mesh.face_count())
    throw InputError(fmt::format(
        "{}: landmark '{}' is on face {}, but the mesh has {} faces; it was picked on another mesh: pick it again, or pass that mesh",
        path.string(), landmark.name, landmark.face, mesh.face_count()));
  if (!landmark.barycentric.allFinite() || landmark.barycentric.minCoeff() < -1e-6 || std::abs(landmark.barycentric.sum() - 1) > 1e-6)
    throw InputError(fmt::format("{}: landmark '{}' has barycentric coordinates that do not lie in its triangle; pick it again",
                                 path.string(), landmark.name));
}

/// A vertex as a landmark: a corner of the first face that uses it.
class VertexLandmarks {
 public:
  explicit VertexLandmarks(const Mesh& mesh) : first_face_(static_cast<std::size_t>(mesh.vertex_count()), {-1, 0}) {
    for (Eigen::Index f = mesh.faces.rows() - 1; f >= 0; --f)
      for (int k = 0; k < 3; ++k) first_face_[static_cast<std::size_t>(mesh.faces(f, k))] = {static_cast<int>(f), k};
  }
  Landmark At(long vertex, const std::string& name, const std::string& where, const char* which) const {
    if (vertex < 0 || vertex >= static_cast<long>(first_face_.size()))
      throw InputError(
          fmt::format("{}: {} vertex {} does not exist, the {} has {} vertices; the pairs were picked on another mesh: pick them again",
                      where, which, vertex, which, first_face_.size()));
    const auto [face, corner] = first_face_[static_cast<std::size_t>(vertex)];
    if (face < 0) throw InputError(fmt::format("{}: {} vertex {} belongs to no face, so it cannot be a landmark", where, which, vertex));
    Landmark landmark;
    landmark.name = name;
    landmark.face = face;
    landmark.barycentric(corner) = 1;
    return landmark;
  }

 private:
  std::vector<std::pair<int, int>> first_face_;
};

std::vector<LandmarkPair> ReadVertexPairs(const fs::path& path, const Mesh& source, const Mesh& target) {
  const VertexLandmarks on_source(source), on_target(target);
  std::istringstream in(ReadFile(path));
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
      throw InputError(where + ": a line must hold 'source_vertex target_vertex', two whole numbers from 0");
    if (const auto [it, is_new] = line_of_source.emplace(s, number); !is_new)
      throw InputError(fmt::format("{}: source vertex {} is in line {} already; delete one", where, s, it->second));
    const std::string name = fmt::format("{}-{}", s, t);
    pairs.push_back({name, on_source.At(s, name, where, "source"), on_target.At(t, name, where, "target")});
  }
  if (pairs.empty()) throw InputError(path.string() + " holds no landmark");
  return pairs;
}

json PlaceOf(const Landmark& landmark) {
  return {{"face", landmark.face}, {"barycentric", {landmark.barycentric(0), landmark.barycentric(1), landmark.barycentric(2)}}};
}

Landmark PlaceFrom(const json& place, const std::string& name, const Mesh& mesh, const fs::path& path) {
  Landmark landmark;
  landmark.name = name;
  landmark.face = place.at("face");
  for (int k = 0; k < 3; ++k) landmark.barycentric(k) = place.at("barycentric").at(static_cast<std::size_t>(k));
  landmark.mesh_id = SignatureOf(mesh);
  RequireOnMesh(landmark, mesh, path);
  return landmark;
}

void RequirePickedOn(const json& root, const char* side, const Mesh& mesh, const fs::path& path) {
  if (!root.contains(side)) return;
  const long vertices = root[side].value("vertices", -1L), faces = root[side].value("faces", -1L);
  if (vertices != mesh.vertex_count() || faces != mesh.face_count())
    throw InputError(
        fmt::format("{}: the pairs were picked on a {} with {} vertices and {} faces, but this one has {}; pick them again, or pass that "
                    "mesh",
                    path.string(), side, vertices, faces, SignatureOf(mesh)));
}

std::vector<LandmarkPair> ReadJsonPairs(const fs::path& path, const std::string& text, const Mesh& source, const Mesh& target) {
  std::vector<LandmarkPair> pairs;
  try {
    const json root = json::parse(text);
    if (!root.contains("pairs") && root.contains("landmarks"))
      throw InputError(path.string() + " holds the picks of one mesh; give the other mesh's picks as a second file");
    RequirePickedOn(root, "source", source, path);
    RequirePickedOn(root, "target", target, path);
    std::set<std::string> names;
    for (const json& entry : root.at("pairs")) {
      LandmarkPair pair;
      pair.name = entry.at("name");
      if (!names.insert(pair.name).second)
        throw InputError(fmt::format("{}: landmark '{}' is there twice; rename or delete one", path.string(), pair.name));
      pair.source = PlaceFrom(entry.at("source"), pair.name, source, path);
      pair.target = PlaceFrom(entry.at("target"), pair.name, target, path);
      pair.confirmed = entry.value("confirmed", true);
      pair.confidence = entry.value("confidence", 1.0);
      pair.origin = entry.value("origin", "");
      pairs.push_back(std::move(pair));
    }
  } catch (const json::exception& error) {
    throw InputError(path.string() + " is not a file of landmark pairs: " + error.what());
  }
  if (pairs.empty()) throw InputError(path.string() + " holds no landmark");
  return pairs;
}

std::vector<Landmark> ReadPickedPoints(const fs::path& path, const Mesh& mesh) {
  boost::property_tree::ptree tree;
  std::istringstream in(ReadFile(path));
  try {
    boost::property_tree::read_xml(in, tree);
  } catch (const boost::property_tree::xml_parser_error& error) {
    throw InputError(fmt::format("{}:{}: not a MeshLab picked-points file: {}", path.string(), error.line(), error.message()));
  }
  const RayScene scene(mesh.points, mesh.faces);
  const double limit = 0.02 * BoundingDiagonal(mesh.points);
  std::vector<Landmark> landmarks;
  for (const auto& [tag, node] : tree.get_child("PickedPoints", {})) {
    if (tag != "point" || node.get<int>("<xmlattr>.active", 1) == 0) continue;
    Landmark landmark;
    landmark.name = node.get<std::string>("<xmlattr>.name", "");
    const Eigen::Vector3d position(node.get<double>("<xmlattr>.x", NAN), node.get<double>("<xmlattr>.y", NAN),
                                   node.get<double>("<xmlattr>.z", NAN));
    if (!position.allFinite()) throw InputError(fmt::format("{}: point '{}' has no x, y, z", path.string(), landmark.name));
    const RayScene::Foot foot = scene.ClosestPoint(position);
    if (std::sqrt(foot.squared_distance) > limit)
      throw InputError(fmt::format(
          "{}: landmark '{}' is {:.3g} away from the mesh, more than 2 % of its diagonal; it was picked on another mesh: pick it again",
          path.string(), landmark.name, std::sqrt(foot.squared_distance)));
    landmark.face = foot.face;
    landmark.barycentric = foot.barycentric;
    landmarks.push_back(landmark);
  }
  RequireUniqueNames(landmarks, path);
  return landmarks;
}

std::vector<Landmark> ReadPicks(const fs::path& path, const Mesh& mesh) {
  const std::string text = ReadFile(path);
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first != std::string::npos && text[first] == '<') return ReadPickedPoints(path, mesh);
  return ReadLandmarks(path, mesh);
}

}  // namespace

std::vector<Landmark> ReadLandmarks(const fs::path& path, const Mesh& mesh) {
  std::vector<Landmark> landmarks;
  try {
    const json root = json::parse(ReadFile(path));
    if (root.contains("mesh")) {
      const long vertices = root["mesh"].value("vertices", -1L), faces = root["mesh"].value("faces", -1L);
      if (vertices != mesh.vertex_count() || faces != mesh.face_count())
        throw InputError(
            fmt::format("{}: the landmarks were picked on a mesh with {} vertices and {} faces, but this one has {}; pick them again, or "
                        "pass that mesh",
                        path.string(), vertices, faces, SignatureOf(mesh)));
    }
    for (const json& entry : root.at("landmarks")) {
      Landmark landmark;
      landmark.name = entry.at("name");
      landmark.face = entry.at("face");
      for (int k = 0; k < 3; ++k) landmark.barycentric(k) = entry.at("barycentric").at(static_cast<std::size_t>(k));
      landmark.mesh_id = SignatureOf(mesh);
      RequireOnMesh(landmark, mesh, path);
      landmarks.push_back(std::move(landmark));
    }
  } catch (const json::exception& error) {
    throw InputError(path.string() + " is not a landmarks file: " + error.what());
  }
  RequireUniqueNames(landmarks, path);
  return landmarks;
}

void WriteLandmarks(const fs::path& path, const Mesh& mesh, const std::vector<Landmark>& landmarks) {
  json root;
  root["schema"] = 1;
  root["mesh"] = {{"vertices", mesh.vertex_count()}, {"faces", mesh.face_count()}};
  root["landmarks"] = json::array();
  for (const Landmark& landmark : landmarks)
    root["landmarks"].push_back({{"name", landmark.name},
                                 {"face", landmark.face},
                                 {"barycentric", {landmark.barycentric(0), landmark.barycentric(1), landmark.barycentric(2)}}});
  WriteFileAtomically(path, root.dump(1) + "\n");
}

void WriteLandmarkPairs(const fs::path& path, const Mesh& source, const Mesh& target, const std::vector<LandmarkPair>& pairs) {
  json root;
  root["schema"] = 1;
  root["source"] = {{"vertices", source.vertex_count()}, {"faces", source.face_count()}};
  root["target"] = {{"vertices", target.vertex_count()}, {"faces", target.face_count()}};
  root["pairs"] = json::array();
  for (const LandmarkPair& pair : pairs)
    root["pairs"].push_back({{"name", pair.name},
                             {"source", PlaceOf(pair.source)},
                             {"target", PlaceOf(pair.target)},
                             {"confidence", pair.confidence},
                             {"origin", pair.origin},
                             {"confirmed", pair.confirmed}});
  WriteFileAtomically(path, root.dump(1) + "\n");
}

std::vector<LandmarkPair> ReadLandmarkPairs(const std::vector<fs::path>& paths, const Mesh& source, const Mesh& target) {
  if (paths.empty()) return {};
  if (paths.size() == 1) {
    const std::string text = ReadFile(paths[0]);
    const std::size_t first = text.find_first_not_of(" \t\r\n");
    if (first != std::string::npos && text[first] == '{') return ReadJsonPairs(paths[0], text, source, target);
    return ReadVertexPairs(paths[0], source, target);
  }
  if (paths.size() > 2)
    throw InputError("landmarks: give one file of pairs, or the source's picks and the target's; not " + std::to_string(paths.size()) +
                     " files");
  const auto on_source = ReadPicks(paths[0], source), on_target = ReadPicks(paths[1], target);
  std::map<std::string, Landmark> by_name;
  for (const Landmark& landmark : on_target) by_name[landmark.name] = landmark;
  std::vector<LandmarkPair> pairs;
  for (const Landmark& landmark : on_source)
    if (const auto it = by_name.find(landmark.name); it != by_name.end()) pairs.push_back({landmark.name, landmark, it->second});
  if (pairs.empty())
    throw InputError(fmt::format("{} and {} share no landmark name; give the same spot of clay the same name on both poses",
                                 paths[0].string(), paths[1].string()));
  return pairs;
}

Eigen::Vector3d PositionOf(const Landmark& landmark, const Mesh& mesh) {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k) position += landmark.barycentric(k) * mesh.points.row(mesh.faces(landmark.face, k)).transpose();
  return position;
}

}  // namespace keypose
