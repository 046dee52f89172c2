#include "cleanup/strategies/cleanup.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "cleanup/repair/handles.h"
#include "cleanup/repair/intersections.h"
#include "cleanup/repair/see_through.h"
#include "cleanup/strategies/changed_faces.h"
#include "cleanup/strategies/measure.h"
#include "cleanup/strategies/repair_strategies.h"
#include "cleanup/support/support_cut.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/values/errors.h"

namespace keypose::cleanup {
namespace {

constexpr double kCountTolerance = 0.01;

// Rounds to a grid far below the merging radius: rounding in another unit must not decide which
// edge is collapsed first.
Mesh Normalized(const Mesh& mesh, const Frame& frame) {
  constexpr double kGrid = 0x1.0p-26;
  Mesh out;
  out.points =
      (((mesh.points.rowwise() - frame.center) / frame.diagonal) / kGrid).array().round() * kGrid;
  out.faces = mesh.faces;
  return out;
}

std::vector<SightLine> Normalized(std::vector<SightLine> lines, const Frame& frame) {
  for (SightLine& line : lines)
    line.origin = (line.origin - frame.center.transpose()) / frame.diagonal;
  return lines;
}

std::optional<double> Normalized(const std::optional<double>& height, const Frame& frame) {
  return height ? std::optional<double>((height.value() - frame.center.z()) / frame.diagonal)
                : std::nullopt;
}

// @param lines  in the frame where the diagonal is 1
// @param ground  in the surface's frame
bool KeptAsIs(const Mesh& surface, const Frame& frame, const CleanupOptions& options,
              const std::vector<SightLine>& lines, const std::optional<double>& ground) {
  if (ground && surface.points.col(2).minCoeff() < *ground) return false;
  if (surface.face_count() > (1 + kCountTolerance) * options.faces) return false;
  if (options.refine && surface.face_count() < (1 - kCountTolerance) * options.faces) return false;
  const ClosedReport report = CheckClosed(surface);
  if (!report.closed() ||
      (options.keep_components > 0 && report.components > options.keep_components))
    return false;
  Mesh scaled;  // scaled to 1, because the predicates' filters only work in a certain range
  scaled.points = (surface.points.rowwise() - frame.center) / frame.diagonal;
  scaled.faces = surface.faces;
  if (SelfIntersects(scaled)) return false;
  if (options.support == "auto" && FindSupport(scaled)) return false;
  const int genus = report.components - report.euler / 2;
  if (genus == 0) return true;
  const int wanted = WantedGenus(scaled, options, lines);
  return genus <= wanted || WithoutHandles(scaled, wanted, lines).cut == 0;
}

// Sets exactly this number, so that all keys stand at the same height.
void SetDown(double ground, double diagonal, Mesh& mesh) {
  constexpr double kRounding = 1e-6;
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v)
    if (mesh.points(v, 2) < ground + kRounding * diagonal) mesh.points(v, 2) = ground;
}

// Wrapping a surface that is hardly more than a line takes minutes, and the result has the
// thickness of the wrap.
void RequireWidth(const Mesh& surface, const Frame& frame) {
  constexpr double kLeastWidth = 1e-5;  // of the diagonal
  const PointsX3 x = (surface.points.rowwise() - frame.center) / frame.diagonal;
  const Eigen::Matrix3d spread =
      (x.rowwise() - x.colwise().mean()).transpose() * (x.rowwise() - x.colwise().mean());
  const Eigen::Vector3d squares =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvalues() / x.rows();
  if (std::sqrt(std::max(0.0, squares[1])) < kLeastWidth)
    throw InputError(
        "cleanup: all vertices lie on a line to within 1e-5 of its length; no surface with a "
        "volume can be made of them. Check that all axes have the same unit");
}

void RequireHandles(const CleanupResult& result, const CleanupOptions& options) {
  if (result.genus >= options.genus) return;
  throw InputError("cleanup: genus is " + std::to_string(options.genus) + ", but the surface has " +
                   std::to_string(result.genus) + " handles that can be kept (strategy '" +
                   result.strategy +
                   "'); ask for that many, or check whether an earlier step closed a window: more "
                   "photographs through it keep it open");
}

}  // namespace

CleanupResult MakeClosedManifold(const Mesh& surface, const CleanupOptions& options,
                                 Progress* progress, const std::vector<SightLine>& lines,
                                 const std::optional<double>& ground) {
  RequireUsable(surface, "surface");
  const Frame frame = {
      (surface.points.colwise().minCoeff() + surface.points.colwise().maxCoeff()) / 2,
      BoundingDiagonal(surface.points)};
  if (!(frame.diagonal > 0) || !std::isfinite(frame.diagonal)) {
    throw InputError(
        "cleanup: the surface has no extent (all vertices coincide, or coordinates overflow); "
        "there is no surface to close");
  }
  RequireWidth(surface, frame);
  CleanupResult result;
  const std::vector<SightLine> seen = Normalized(lines, frame);
  if (KeptAsIs(surface, frame, options, seen, ground)) {
    result.mesh = surface;
    result.strategy = "as-is";
    Measure(surface, frame.diagonal, result);
    result.genus_before = result.genus;
    result.handles_seen_through = HandlesSeenThrough(surface, lines);
    RequireHandles(result, options);
    return result;
  }
  const Mesh normalized = Normalized(surface, frame);
  RepairStrategies strategies(normalized, options, seen, Normalized(ground, frame), frame, progress,
                              result);
  result.mesh = strategies.OnGround(strategies.Run());
  ReportProgress(progress, 0.9, "measuring");
  MeasureDistances(result.mesh, normalized, strategies.kept(), result);
  const double edge =
      std::sqrt(4 / std::sqrt(3.0) * SurfaceArea(result.mesh.points, result.mesh.faces) /
                result.mesh.face_count());
  MeasureUndamaged(result.mesh, strategies.kept(), strategies.Changed(), edge, result);
  result.mesh.points = frame.Of(result.mesh.points);
  if (ground) SetDown(*ground, frame.diagonal, result.mesh);
  if (surface.colors.rows() == surface.points.rows())
    result.mesh.colors = ColorsFrom(surface, result.mesh.points);
  Measure(result.mesh, frame.diagonal, result);
  result.genus_before = std::max(result.genus_before, result.genus);
  result.handles_seen_through = HandlesSeenThrough(result.mesh, lines);
  RequireHandles(result, options);
  return result;
}

}  // namespace keypose::cleanup
