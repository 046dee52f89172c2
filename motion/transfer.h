// The motion of a template, transferred to another mesh by marks.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/values/mesh.h"
#include "core/values/progress.h"
#include "motion/fields/mark_fields.h"
#include "motion/fields/mark_turns.h"
#include "motion/fields/marks.h"
#include "motion/root/holds.h"

namespace keypose::motion {

enum class TransferMethod {
  kAuto,
  kPaper,    ///< the paper's equations, many frames at once
  kLiteral,  ///< the paper's equations, step by step
};

struct TransferOptions {
  TransferMethod method = TransferMethod::kAuto;
  bool align = true;   ///< the motion is turned into the target's own directions
  bool follow = true;  ///< marks may turn by more than half a turn over several frames
  bool rest =
      true;  ///< auto: limbs that the target holds otherwise at rest take the template's pose
  bool volume = true;  ///< auto: closed parts keep their volume
  double stretch = 0;  ///< auto: share of the template's own stretch that is transferred, 0 to 1
  double scale = 0;    ///< of the root's path; 0: the ratio of the legs' lengths
  bool feet = true;    ///< auto: feet that stand do not slide, and none sinks into the ground
  double fps = 24;     ///< of the motion: tells how fast feet move
  std::vector<Pin> pins = {};  ///< auto: marks that are held
};

struct TransferReport {
  Alignment alignment;
  bool turned = false;    ///< the motion was turned by the alignment's heading, or by all of it
  double path_scale = 1;  ///< of the root's path
  double largest_rest_turn = 0;  ///< of a limb from the target's rest pose to the template's [rad]
  double least_weight = 0;       ///< of the harmonic fields
  int unmarked_parts = 0;
  double largest_turn_between = 0;   ///< of two neighbouring marks [rad]
  double volume_before = 0;          ///< largest |volume / rest - 1| before the correction
  double volume_move_over_diag = 0;  ///< largest displacement of a vertex by the correction
  HoldsReport holds;

  /// Takes the figures of one frame where they are worse.
  void TakeWorst(const TransferReport& frame);
};

/// Transfers a motion to a target.
///
/// First each frame of the template is added, in order; of it, only what its marks do is kept. Then
/// Run makes the target's frames, a batch at a time.
///
/// `paper`: quaternions at the marked triangles, relative to the template's reference pose, four
/// harmonic fields, rotated triangles, one factor; the marks' mean follows the template's.
/// `auto` departs: rotation vectors relative to the body, followed over time, in place of
/// quaternions; fields that cannot overshoot; the volume at rest is kept; the path of the body is
/// scaled by the legs; feet that stand do not slide; marks can be pinned.
/// Source: de Aguiar et al., animation of human scans from multi-view video.
class Transfer {
 public:
  /// @param target     in its reference pose
  /// @param reference  template in its reference pose, which resembles the target's
  /// @throws InputError   an unusable mesh, mark or pin; template and target face opposite ways and
  /// options.align is off
  /// @throws SolverError
  Transfer(const Mesh& target, const PointsX3& reference, const FacesX3& template_faces,
           const std::vector<Mark>& marks, const TransferOptions& options);
  ~Transfer();

  /// @param name  of the frame, for messages
  /// @throws InputError  a mark's triangle has no area in this frame
  void Add(const PointsX3& frame, const std::string& name);
  int frame_count() const;

  /// Calls `take` with each frame of the target, V x 3, in order.
  /// Same bits for any thread count.
  void Run(const std::function<void(int frame, const PointsX3& points)>& take,
           Progress* progress = nullptr);
  /// One frame by itself, as Run makes it. The first call plans what is held.
  PointsX3 Frame(int frame);
  const TransferReport& report() const;
  /// A frame moved, turned and scaled to where the template is: over the films that it was tracked
  /// in.
  PointsX3 InTemplateSpace(const PointsX3& points) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace keypose::motion
