// Reads and writes landmarks: named points on a mesh, or pairs of points on two meshes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/io/project/carry_log.h"
#include "core/values/mesh.h"

namespace keypose {

/// A point on a mesh.
struct Landmark {
  std::string name;
  int face = -1;
  Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();
};

/// One landmark on two meshes.
struct LandmarkPair {
  std::string name;
  Landmark source, target;
  bool confirmed = true;    ///< false: a suggestion that no person has confirmed
  double confidence = 1;    ///< of a suggestion, 0 to 1
  std::string origin = {};  ///< how a suggestion was found: "tip", "intrinsic"; else empty
};

/// Reads the picks of one pose from JSON. Each pick has a face, barycentric coordinates and a
/// place, and the file says which mesh it was picked on (docs/file-formats.md). On that mesh, face
/// and coordinates are used. On a mesh that was rebuilt since, the places are transferred
/// (core/surfaces/carry.h).
///
/// Files of schema 1 only hold that mesh's vertex and face counts. If the counts are the same, face
/// and coordinates are used, and `log` gets a warning.
/// @param side  the name of the mesh in messages
/// @param log   may be null
/// @throws InputError  malformed, a repeated name, a face that the mesh does not have, other counts
/// (schema 1), or picks that could not be transferred; names the landmarks
std::vector<Landmark> ReadLandmarks(const std::filesystem::path& path, const Mesh& mesh,
                                    CarryLog* log = nullptr, const std::string& side = "mesh");
void WriteLandmarks(const std::filesystem::path& path, const Mesh& mesh,
                    const std::vector<Landmark>& landmarks);

/// Writes pairs, and how they were found, to one file. The file holds the bindings of both meshes.
void WriteLandmarkPairs(const std::filesystem::path& path, const Mesh& source, const Mesh& target,
                        const std::vector<LandmarkPair>& pairs);

/// Reads pairs from one file or from two. One file: text lines `source_vertex target_vertex`,
/// counted from 0, or the JSON of WriteLandmarkPairs. Two files: picks of the source and of the
/// target (each as ReadPicks takes them), matched by name. MeshLab's points are free positions;
/// each is moved to the closest point of the mesh. They must lie on the mesh: a point more than 2 %
/// of the diagonal away, or a median distance above 0.5 %, is an error. Unconfirmed pairs that
/// cannot be transferred to a rebuilt mesh are left out.
/// @throws InputError  as above, and when the two files share no name
std::vector<LandmarkPair> ReadLandmarkPairs(const std::vector<std::filesystem::path>& paths,
                                            const Mesh& source, const Mesh& target,
                                            CarryLog* log = nullptr);
/// Reads the picks of one mesh: our JSON, MeshLab's .pp, or Faceform Wrap's points, which are
/// {"name": [face, u, v]} or, numbered from 1, [[face, u, v]], at u A + v B + (1 - u - v) C of the
/// face's corners A, B, C. Wrap's files do not say which mesh they were picked on: face numbers are
/// used unchanged, and `log` gets a warning.
/// @throws InputError  as above
std::vector<Landmark> ReadPicks(const std::filesystem::path& path, const Mesh& mesh,
                                CarryLog* log = nullptr, const std::string& side = "mesh");

/// Whether a file holds picks in photographs, of a pose from few photographs, and none on a mesh.
bool HoldsPhotoPicksOnly(const std::filesystem::path& path);

/// Picks as MeshLab's picked points (.pp), which ReadPicks reads again.
std::string PickedPointsText(const std::vector<Landmark>& landmarks, const Mesh& mesh);
/// Picks as Wrap's named points, which ReadPicks reads again.
/// @pre names are valid UTF-8, and no two are equal
std::string WrapPointsText(const std::vector<Landmark>& landmarks);

Eigen::Vector3d PositionOf(const Landmark& landmark, const Mesh& mesh);

}  // namespace keypose
