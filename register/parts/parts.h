// Loose parts: small separate pieces, such as eyeballs, that must follow the surface they sit on.
#pragma once

#include <vector>

#include "core/landmark_goal.h"
#include "core/mesh.h"

namespace keypose::registration {

/// A piece that is not connected to what it sits on, and how it is bound to that.
struct LoosePart {
  std::vector<int> vertices;  ///< of the mesh, ascending
  int parent = -1;  ///< index of the loose part it sits on (a pupil on an eyeball), or -1: it sits
                    ///< on the host
  /// vertices of the host (or of the parent) whose motion it takes, ascending
  std::vector<int> anchors;
  Eigen::VectorXd weights;  ///< one an anchor, positive, summing to 1
  double diagonal = 0;      ///< of its bounding box
};

struct LooseParts {
  std::vector<LoosePart> parts;    ///< a parent comes before the parts that sit on it
  std::vector<int> host_vertices;  ///< all vertices that are not loose, ascending
  bool empty() const { return parts.empty(); }
};

struct LoosePartOptions {
  double largest_share = 0.3;  ///< a component whose bounding diagonal is under this share of the
                               ///< largest one's is loose
};

/// The mesh's loose parts, bound to the nearest surface of a larger component. Vertices at the same
/// place count as connected, so that a mesh cut at seams is one piece. Unused vertices belong to
/// the host. A mesh whose components are all large has none.
/// @throws InputError  unusable mesh
/// Deterministic.
LooseParts FindLooseParts(const Mesh& mesh, const LoosePartOptions& options = {});

/// The mesh without its loose parts (points and faces only); vertex i of it is vertex
/// parts.host_vertices[i] of `mesh`.
Mesh HostOf(const Mesh& mesh, const LooseParts& parts);

/// All points, where each loose part has taken the similarity (rotation, translation, scale within
/// 25 % of the host's own) that best fits its anchors' motion: no shear, and exact where the host
/// moves rigidly.
/// @param moved  V x 3; rows of loose parts are not read
PointsX3 MoveLooseParts(const Mesh& source, const LooseParts& parts, const PointsX3& moved);
/// The same when only the host was registered: row i of `moved_host` is vertex
/// parts.host_vertices[i].
PointsX3 MoveLoosePartsWithHost(const Mesh& source, const LooseParts& parts,
                                const PointsX3& moved_host);

/// Moves loose parts onto what is known of them on the target: a part with landmarks of its own
/// takes them (one: a shift; two or more: a rigid motion fitted with the part's own place as a weak
/// prior); a part with a clear counterpart among the target's loose parts (centres nearest to each
/// other, within the part's size; size within 40 %) shifts onto its centre. Parts on a moved part
/// follow it.
struct RefinedParts {
  PointsX3 points;
  int by_landmarks = 0, by_counterpart = 0;
};
RefinedParts RefineLooseParts(const Mesh& source, const LooseParts& parts, const PointsX3& moved,
                              const Mesh& target, const LooseParts& target_parts,
                              const std::vector<LandmarkGoal>& landmarks);

}  // namespace keypose::registration
