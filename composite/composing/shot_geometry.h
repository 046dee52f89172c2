// The character's vertices in the set's world, at any time of a shot.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "composite/plan/camera_path.h"
#include "composite/plan/film_plan.h"
#include "composite/plan/placement.h"
#include "core/values/filmed_shot.h"
#include "core/values/mesh.h"
#include "views/film/ground_shadow.h"

namespace keypose::composite {

/// A filmed frame that was located.
struct Anchor {
  int animation = 0;   ///< frame of the animation that it shows
  int shot_frame = 0;  ///< index into the shot's frames
};

class ShotGeometry {
 public:
  /// @param frames  the animation's, of one connectivity; must outlive this object
  /// @throws InputError  no located frame lies within the animation; of a moving camera fewer than
  /// two
  ShotGeometry(const FilmedShot& shot, const FilmPlan& plan, const std::vector<Mesh>& frames,
               const AnimationTimes& times);
  const std::vector<Anchor>& anchors() const { return anchors_; }
  bool still() const { return shot_.still; }
  /// The lens and the camera's place. A moving camera's goes smoothly from located frame to located
  /// frame, and stands before the first and after the last of them.
  View ViewAt(double animation_frame) const;

  /// Where an animation's frame lies between two anchors; outside of them both are the nearest one.
  struct Between {
    int before = 0, after = 0;  ///< indices of anchors
    double share = 0;           ///< of the way
  };
  Between At(double animation_frame) const;
  /// The share of the way in the timeline's time from one frame of the animation to another.
  double ShareOfWay(int from, int to, double animation_frame) const;
  /// Vertices in world. Between two frames they go straight.
  /// @param animation_frame  clamped to the animation
  PointsX3 Points(double animation_frame) const;
  /// From now on the vertices have these shifts in world at frames of the animation, and shifts
  /// between those of the nearest two at others; beyond the last of them the nearest one's.
  void SetShifts(std::map<int, PointsX3> shifts) { shifts_ = std::move(shifts); }
  /// The table: z = 0 of the character, or the plane of its lowest point where that is elsewhere.
  Ground Table() const;

 private:
  PointsX3 PointsOfFrame(int frame) const;
  PointsX3 ShiftsOfFrame(int frame) const;
  const Similarity3& PlaceOf(const Anchor& anchor) const;

  FilmedShot shot_;
  const std::vector<Mesh>& frames_;
  std::vector<double> t_;  // time of each frame
  std::vector<Anchor> anchors_;
  std::optional<CameraPath> path_;      // of a moving camera
  std::map<int, PointsX3> shifts_;      // by frame of the animation
  std::vector<PlacementBetween> ways_;  // from each anchor to the next
};

}  // namespace keypose::composite
