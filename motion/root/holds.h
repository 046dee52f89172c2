// All that is held in a motion: feet on the ground, and marks pinned to places.
#pragma once

#include <functional>
#include <future>
#include <optional>
#include <string>
#include <vector>

#include "core/values/mesh.h"
#include "motion/fields/marks.h"
#include "motion/root/feet.h"
#include "motion/root/held_patches.h"
#include "motion/root/patch_paths.h"
#include "motion/root/placed_poses.h"

namespace keypose::motion {

/// A mark that is held, such as a hand on a prop.
struct Pin {
  std::string mark;                      ///< its name
  int first = 0, last = 0;               ///< frames, both included
  std::optional<Eigen::RowVector3d> at;  ///< in the target's space; none: where it is at `first`
};

struct HoldsReport {
  int soles = 0;          ///< patches of the target that the template has too
  int contacts = 0;       ///< times that a patch stands, each of several frames
  double root_shift = 0;  ///< largest displacement of the whole body for its feet
  double held_move = 0;   ///< largest displacement of a vertex by what is held
};

/// Plans and applies what is held. The order: construct, Watch each frame of the template, Plan
/// once, then GoalsOf each frame of the target, for PoseSettler.
class Holds {
 public:
  /// @param feet  whether soles stand where the template's do
  /// @throws InputError  a pin of a mark that does not exist, or whose frames are in the wrong
  /// order
  Holds(const PointsX3& target, const FacesX3& faces, const std::vector<Mark>& marks,
        const PointsX3& reference, const FacesX3& template_faces,
        const std::function<Eigen::RowVector3d(const Eigen::RowVector3d&)>& target_from_template,
        const std::vector<Pin>& pins, bool feet);

  bool any() const { return !soles_.empty() || !pins_.empty(); }
  /// Measures the template's soles in its next frame.
  void Watch(const PointsX3& template_frame);
  /// @param frames  their roots are shifted
  /// @throws InputError  a pin beyond the last frame, or two pins of one mark at once
  void Plan(const PoissonSystem& system, const RootPath& path, double fps,
            std::vector<MotionFrame>& frames);
  /// Where patches belong in this frame, from where they are: soles by their centres, pinned ones
  /// by their marks.
  std::vector<HeldPatches::Goal> GoalsOf(int frame, const PointOf& point_of) const;
  /// None before Plan, or where nothing is held.
  const HeldPatches* patches() const { return patches_ ? &*patches_ : nullptr; }
  const HoldsReport& report() const { return report_; }
  HoldsReport& report() { return report_; }

 private:
  struct Sole {
    SolePatch on_target;
    SolePatch on_template;
    SoleTrack track;  // of the template; grows by Watch
    std::vector<char> contact;
    PatchHold hold;
    PointsX3 places;  // T x 3, of the centre, where it is held exactly
  };
  struct Pinned {
    Pin pin;
    MarkPlace place;
    std::vector<int> vertices;
    PatchHold hold;
    Eigen::RowVector3d at;
  };
  void PlanSoles(const std::vector<PointsX3>& tracks, double fps, std::vector<MotionFrame>& frames);
  void PlanPin(Pinned& pinned, const PointsX3& track);

  PointsX3 target_;
  FacesX3 faces_;
  std::vector<Mark> marks_;
  std::vector<Sole> soles_;
  std::vector<Pinned> pins_;
  std::vector<Eigen::RowVector3d> centres_seen_;  // soles x frames, frame after frame
  std::vector<double> lowest_seen_;
  double template_height_ = 0, ground_ = 0, diagonal_ = 1;
  std::optional<HeldPatches> patches_;
  HoldsReport report_;
  std::future<SmallCopy> copy_;  // of the target; made beside what else is set up
};

}  // namespace keypose::motion
