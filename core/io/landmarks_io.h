// Landmarks: named points on a mesh, or pairs between two meshes.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/io/carry_log.h"
#include "core/mesh.h"

namespace keypose {

/// A point on a mesh.
struct Landmark {
  std::string name;
  int face = -1;
  Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();
};

/// The point of the mesh that two landmark sets share.
struct LandmarkPair {
  std::string name;
  Landmark source, target;
  bool confirmed = true;    ///< false: a program's suggestion that no person has confirmed
  double confidence = 1;    ///< of a suggestion, 0 to 1
  std::string origin = {};  ///< of a suggestion, for a person: "tip", "intrinsic"; else empty
};

/// One pose's picks from JSON. Each has its face and barycentric coordinates, its place, and the
/// file tells which mesh it was picked on (docs/file-formats.md). On that mesh the numbers count;
/// on one that was made anew the places are carried over (core/carry.h).
///
/// Files of schema 1 only tell that mesh's counts: their numbers are taken as they are where the
/// counts are the same, and `log` warns.
/// @param side  what messages call the mesh
/// @param log   may be null
/// @throws InputError  malformed, a name twice, a face that the mesh does not have, other counts
/// (schema 1), or picks that could not be
///                     carried over; names the landmarks
std::vector<Landmark> ReadLandmarks(const std::filesystem::path& path, const Mesh& mesh,
                                    CarryLog* log = nullptr, const std::string& side = "mesh");
void WriteLandmarks(const std::filesystem::path& path, const Mesh& mesh,
                    const std::vector<Landmark>& landmarks);

/// Pairs in one file, with where each came from: as above, for source and target.
void WriteLandmarkPairs(const std::filesystem::path& path, const Mesh& source, const Mesh& target,
                        const std::vector<LandmarkPair>& pairs);

/// Pairs from one file (text lines `source_vertex target_vertex`, 0-based, or the JSON of
/// WriteLandmarkPairs) or two (JSON picks or MeshLab .pp of source and target, joined by name).
/// MeshLab's points are free positions, which snap to the closest point of the mesh. On the mesh
/// that they were picked on they lie exactly; more than 2 % of the diagonal away, or most of them
/// more than 0.5 %, is an error. Unconfirmed pairs that cannot be carried over to a mesh made anew
/// are left out.
/// @throws InputError  as above, and when the two files share no name
std::vector<LandmarkPair> ReadLandmarkPairs(const std::vector<std::filesystem::path>& paths,
                                            const Mesh& source, const Mesh& target,
                                            CarryLog* log = nullptr);
/// The picks of one mesh, JSON or .pp.
/// @throws InputError  as above
std::vector<Landmark> ReadPicks(const std::filesystem::path& path, const Mesh& mesh,
                                CarryLog* log = nullptr, const std::string& side = "mesh");

Eigen::Vector3d PositionOf(const Landmark& landmark, const Mesh& mesh);

}  // namespace keypose
