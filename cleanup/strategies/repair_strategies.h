// The repair strategies, tried in order until the result of one passes the test. The least
// destructive one is tried first.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cleanup/strategies/cleanup_options.h"
#include "cleanup/strategies/cleanup_result.h"
#include "cleanup/support/support_cut.h"
#include "core/pictures/sight_lines.h"
#include "core/values/progress.h"

namespace keypose::cleanup {

/// Whether a mesh satisfies what the cleanup guarantees: closed, oriented, one fan per vertex,
/// positive volume, no face without area, no self-intersections.
bool Acceptable(const Mesh& mesh);

/// The number of handles that a closed surface may keep under these options.
/// @param lines  in the surface's frame
int WantedGenus(const Mesh& closed, const CleanupOptions& options,
                const std::vector<SightLine>& lines);

/// The transformation from the normalised frame, where the diagonal is 1, back to the surface's own
/// unit.
struct Frame {
  Eigen::RowVector3d center;
  double diagonal = 1;
  PointsX3 Of(const PointsX3& normalized) const {
    return (normalized * diagonal).rowwise() + center;
  }
};

/// One run of the strategies. All computations are in a frame where the diagonal is 1, so
/// tolerances do not depend on the unit.
class RepairStrategies {
 public:
  /// @param lines   of sight through the figure, in the same frame
  /// @param ground  height along z, in the same frame; everything below is removed
  /// @param frame  frame of the result; a mesh that self-intersects after rounding in this frame is
  /// rejected
  RepairStrategies(const Mesh& surface, const CleanupOptions& options,
                   const std::vector<SightLine>& lines, std::optional<double> ground,
                   const Frame& frame, Progress* progress, CleanupResult& result)
      : input_(surface),
        options_(options),
        lines_(lines),
        ground_(ground),
        frame_(frame),
        progress_(progress),
        result_(result) {}

  /// The finished mesh.
  /// @throws InputError @throws QualityError
  Mesh Run();
  /// The mesh with its lower vertices raised to the ground, if that is acceptable; else the mesh.
  Mesh OnGround(const Mesh& mesh) const;
  /// The mesh that the result is compared with: the input without removed pieces and support.
  const Mesh& kept() const { return kept_; }
  /// Faces that only one of two meshes has: the working mesh and the repaired mesh before
  /// remeshing.
  Mesh Changed() const;

 private:
  std::optional<Mesh> Try(const char* strategy, const std::function<std::optional<Mesh>()>& step);
  void Weld();
  void RemoveSupport();
  void CutAtGround();
  Mesh Cut(const CutPlane& plane);
  void Fill();
  std::optional<Mesh> Welded();
  std::optional<Mesh> MendedWhole();
  std::optional<Mesh> Wrap(double alpha, double offset_share, bool project);
  std::optional<Mesh> WrapStrategies();
  std::optional<Mesh> CoarseWraps(double alpha);
  std::optional<Mesh> Finish(const Mesh& base);
  std::optional<Mesh> AtWantedSize(const Mesh& base);
  std::optional<Mesh> Mended(const Mesh& mesh);
  Mesh WithGenus(const Mesh& mesh);
  Mesh WithBetterAngles(const Mesh& mesh, double enough_deg);
  bool GoodSize(int faces) const;
  bool MustHitCount() const { return options_.refine || kept_.face_count() > options_.faces; }
  bool MayStay(int faces) const;
  bool Apart(const Mesh& mesh) const;
  bool AcceptableInFrame(const Mesh& mesh) const;

  const Mesh& input_;
  const CleanupOptions& options_;
  const std::vector<SightLine>& lines_;
  std::optional<double> ground_;
  Frame frame_;
  Progress* progress_;
  CleanupResult& result_;
  Mesh kept_;      // merged vertices, without small pieces and support; full detail
  Mesh working_;   // the same, with at most a few times the wanted faces
  Mesh filled_;    // the working mesh with its holes filled
  Mesh repaired_;  // the mesh that the last strategy brought to the wanted size
  bool wrapped_ = false;
  std::string last_fault_;
};

}  // namespace keypose::cleanup
