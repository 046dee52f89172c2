// Poses that keep their volume while some of their patches are held.
#pragma once

#include <functional>
#include <vector>

#include "core/values/mesh.h"
#include "motion/reconstruct/kept_volume.h"
#include "motion/root/held_patches.h"

namespace keypose::motion {

/// Brings a pose to its volume, and its held patches to their places while the volume stays.
///
/// The displacement is a step along each part's volume field and a pull on each held patch. Places
/// are linear in both. Volumes are measured anew after each step, and the step's slope is that of
/// the first pose with the curvature at rest: so the costly measure is made once a pose.
class PoseSettler {
 public:
  /// @param volume, held  either may be null; must outlive this
  PoseSettler(const KeptVolume* volume, const HeldPatches* held) : volume_(volume), held_(held) {}

  struct Report {
    double deviation = 0;    ///< largest |volume / rest - 1| of a part before
    double volume_move = 0;  ///< largest displacement of a vertex for its volume
    double held_move = 0;    ///< largest displacement of a vertex by what is held
  };
  /// Memory that is used again, one for each thread.
  struct Space {
    KeptVolume::State state;
    std::vector<char> kept;  // of each part: whether its volume is in reach
    std::vector<double> steps,
        missing;  // of each part: all steps so far, the volume that is missing
  };
  /// Where patches belong, from where they are at the pose's volume, as near as one step comes.
  using GoalsOf = std::function<std::vector<HeldPatches::Goal>(const PointOf&)>;
  /// Held points are then exactly at their goals, and volumes within 1e-5.
  void Settle(const GoalsOf& goals_of, PointsX3& pose, Space& space, Report& report) const;

 private:
  struct Step;
  bool KeepsVolume() const { return volume_ && volume_->any_closed(); }
  Step StepToVolume(const PointsX3& pose, Space& space, Report& report) const;
  Step StepTo(const std::vector<HeldPatches::Goal>& goals, const PointsX3& pose,
              const Space& space) const;
  Eigen::MatrixXd MovesOfCentres(const std::vector<HeldPatches::Goal>& goals,
                                 const Space& space) const;
  double Move(const Step& step, PointsX3& pose, const Space& space) const;
  bool HasVolume(const Space& space) const;
  void FindMissing(const PointsX3& pose, Space& space) const;

  const KeptVolume* volume_;
  const HeldPatches* held_;
};

}  // namespace keypose::motion
