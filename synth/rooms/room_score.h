// How far what was made of a room's photographs is from its truth.
#pragma once

#include <string>
#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose::synth {

struct RoomCameraScore {
  Similarity3
      truth_from_model;       ///< with which most cameras agree; identity where none can be found
  int total = 0, placed = 0;  ///< photographs; those that the model has
  /// more than 2 degrees, or 5 % of the distance to the figure, from the truth
  std::vector<std::string> wrong, missing;
  double median_deg = 0, median_over_distance = 0;  ///< of those that are right
  int good() const { return placed - static_cast<int>(wrong.size()); }
};

/// Wrong cameras do not spoil the alignment: of the similarities that two cameras each fix, the one
/// with which most agree is taken, and refined by those.
/// @param center  of the figure, in the truth's frame
RoomCameraScore ScoreRoomCameras(const Scene& truth, const Scene& model,
                                 const Eigen::Vector3d& center);

/// The number of the model's cameras whose directions, up to one common turn, agree with `truth` to
/// 2 degrees. Of cameras on one tripod, whose places say nothing.
int AgreeingTurns(const Scene& truth, const Scene& model);

/// Pixels of both over pixels of either; 1 where both are empty.
/// @param mask  may have another size than the truth; it is then enlarged or shrunk
/// @throws InputError  it has another shape
double MaskOverlap(const Image8& truth, const Image8& mask);

/// What a mesh has too much at its foot. Shares of the true surface's diagonal.
struct BaseScore {
  double below = 0;          ///< lowest point under the plane that the figure stands on
  double beside = 0;         ///< 99 % of the surface in the lowest eighth is not farther outside
  double anywhere = 0;       ///< the same of the whole surface
  double mean_to_truth = 0;  ///< mean distance of the mesh's points from the true surface
  double missing = 0;        ///< 99 % of the true surface is not farther from the mesh
};
/// The alignment is refined by what lies above the foot.
/// @param mesh  in the model's frame
BaseScore ScoreBase(const Mesh& truth, const Mesh& mesh, const Similarity3& truth_from_model);

}  // namespace keypose::synth
