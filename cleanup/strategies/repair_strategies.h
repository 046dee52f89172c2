// The repair strategies: the least destructive one whose result passes the test.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cleanup/strategies/cleanup_options.h"
#include "cleanup/strategies/cleanup_result.h"
#include "cleanup/support/support_plane.h"
#include "core/progress.h"
#include "core/sight_lines.h"

namespace keypose::cleanup {

/// Whether a mesh is what the clean-up promises: closed, oriented, one fan a vertex, volume, no
/// face without area, nothing crosses.
bool Acceptable(const Mesh& mesh);

/// Handles that the options let a closed surface keep.
/// @param lines  in its frame
int WantedGenus(const Mesh& closed, const CleanupOptions& options,
                const std::vector<SightLine>& lines);

/// Where the surface lies in its own unit.
struct Frame {
  Eigen::RowVector3d center;
  double diagonal = 1;
  PointsX3 Of(const PointsX3& normalized) const {
    return (normalized * diagonal).rowwise() + center;
  }
};

/// One run; everything happens in a frame where the diagonal is 1, so that no tolerance depends on
/// the unit.
class RepairStrategies {
 public:
  /// @param lines   of sight through the figure, in the same frame
  /// @param ground  height along z below which nothing stays, in the same frame
  /// @param frame   where the result goes: what crosses itself by its rounding there is no result
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
  /// The same with nothing below the ground, where that leaves it acceptable.
  Mesh OnGround(const Mesh& mesh) const;
  /// What the result is to be compared with: the input without dropped pieces and stand.
  const Mesh& kept() const { return kept_; }
  /// Faces that only one has, the kept input or what was made of it before it was brought to its
  /// size.
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
  Mesh kept_;      // welded, without bits and stand; all of its detail
  Mesh working_;   // the same with at most a few times the wanted faces
  Mesh filled_;    // that without holes
  Mesh repaired_;  // what the last strategy brought to the wanted size
  bool wrapped_ = false;
  std::string last_fault_;
};

}  // namespace keypose::cleanup
