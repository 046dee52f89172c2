// Landmarks: named points on a mesh, or pairs between two meshes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/mesh.h"

namespace keypose {

/// A point on a mesh.
struct Landmark {
  std::string name;
  int face = -1;
  Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();
  std::string mesh_id;  ///< "V vertices, F faces" signature of the mesh it was picked on, may be empty
};

/// The point of the mesh that two landmark sets share.
struct LandmarkPair {
  std::string name;
  Landmark source, target;
  bool confirmed = true;    ///< false: a program's suggestion that no person has confirmed
  double confidence = 1;    ///< of a suggestion, 0 to 1
  std::string origin = {};  ///< of a suggestion, for a person: "tip", "intrinsic"; else empty
};

/// One pose's picks from JSON: {"schema":1,"mesh":{"vertices":V,"faces":F},"landmarks":[{"name":..,"face":..,"barycentric":[a,b,c]},...]}.
/// @throws InputError  malformed, a name twice, a face that `mesh` does not have, or picked on a mesh of other counts; names the landmark
std::vector<Landmark> ReadLandmarks(const std::filesystem::path& path, const Mesh& mesh);
void WriteLandmarks(const std::filesystem::path& path, const Mesh& mesh, const std::vector<Landmark>& landmarks);

/// Pairs in one file, with where each came from: {"schema":1,"source":{"vertices":V,"faces":F},"target":{...},"pairs":[{"name":..,
/// "source":{"face":..,"barycentric":[a,b,c]},"target":{...},"confidence":0..1,"origin":..,"confirmed":true|false},...]}.
void WriteLandmarkPairs(const std::filesystem::path& path, const Mesh& source, const Mesh& target, const std::vector<LandmarkPair>& pairs);

/// Pairs from one file (text lines `source_vertex target_vertex`, 0-based, or the JSON of WriteLandmarkPairs) or two (JSON picks or MeshLab
/// .pp of source and target, joined by name). MeshLab's points are free positions: they snap to the closest point of the mesh, and more
/// than 2 % of the diagonal away is an error.
/// @throws InputError  as above, and when the two files share no name
std::vector<LandmarkPair> ReadLandmarkPairs(const std::vector<std::filesystem::path>& paths, const Mesh& source, const Mesh& target);

Eigen::Vector3d PositionOf(const Landmark& landmark, const Mesh& mesh);

}  // namespace keypose
