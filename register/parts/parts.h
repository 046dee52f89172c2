// Loose parts: small separate pieces, such as eyeballs, that must follow the surface they sit on.
#pragma once

#include <vector>

#include "core/values/landmark_goal.h"
#include "core/values/mesh.h"

namespace keypose::registration {

/// A small piece that is not connected to the surface it sits on. The host is the rest of the mesh.
struct LoosePart {
  std::vector<int> vertices;  ///< of the mesh, ascending
  int parent = -1;  ///< index of the loose part it sits on (a pupil on an eyeball), or -1: it sits
                    ///< on the host
  /// Vertices of the host (or of the parent) whose motion it follows, ascending
  std::vector<int> anchors;
  Eigen::VectorXd weights;  ///< one per anchor, positive, summing to 1
  double diagonal = 0;      ///< of its bounding box [length]
};

/// All loose parts of a mesh, and the host.
struct LooseParts {
  std::vector<LoosePart> parts;    ///< a parent comes before the parts that sit on it
  std::vector<int> host_vertices;  ///< all vertices that are not loose, ascending
  bool empty() const { return parts.empty(); }
};

struct LoosePartOptions {
  double largest_share = 0.3;  ///< a component is loose when its bounding diagonal is less than
                               ///< this share of the largest one's
};

/// Finds the loose parts of a mesh and binds each to the nearest surface: the host's, or that of a
/// larger loose part. Two sides of a seam count as connected. Unused vertices belong to the host.
/// @throws InputError  unusable mesh
/// Deterministic.
LooseParts FindLooseParts(const Mesh& mesh, const LoosePartOptions& options = {});

/// The mesh without its loose parts (points and faces only). Its vertex i is vertex
/// parts.host_vertices[i] of `mesh`.
Mesh HostOf(const Mesh& mesh, const LooseParts& parts);

/// Moves each loose part by the similarity transform that best fits the motion of its anchors. Its
/// scale stays within 25 % of the host's own. There is no shear, and the result is exact where the
/// host moves rigidly.
/// @param moved  V x 3; rows of loose parts are not read
/// @return V x 3, with all parts
/// @throws InputError  `moved` has another number of rows
PointsX3 MoveLooseParts(const Mesh& source, const LooseParts& parts, const PointsX3& moved);
/// The same when only the host was registered.
/// @param moved_host  row i is vertex parts.host_vertices[i]
PointsX3 MoveLoosePartsWithHost(const Mesh& source, const LooseParts& parts,
                                const PointsX3& moved_host);

/// The result of RefineLooseParts.
struct RefinedParts {
  PointsX3 points;                           ///< V x 3
  int by_landmarks = 0, by_counterpart = 0;  ///< number of parts that were moved in each way
};
/// Moves loose parts onto their landmarks or their counterparts on the target.
///
/// - A part with landmarks of its own moves onto them. One landmark gives a shift. Two or more give
///   a rigid motion, with the part's current orientation as a weak prior.
/// - Otherwise, a part with a clear counterpart among the target's loose parts is shifted onto its
///   centre and then fitted to it by ICP. Clear means: the two centres are nearest to each other
///   and closer than 0.75 of the part's size, and the sizes differ by a factor of 1.4 at most.
///
/// Parts that sit on a moved part follow it.
/// @param moved  V x 3, the registered mesh with its loose parts
RefinedParts RefineLooseParts(const Mesh& source, const LooseParts& parts, const PointsX3& moved,
                              const Mesh& target, const LooseParts& target_parts,
                              const std::vector<LandmarkGoal>& landmarks);

}  // namespace keypose::registration
