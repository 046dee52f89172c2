#include "deform/mending/mend.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/values/errors.h"
#include "deform/mending/brushed.h"
#include "deform/mending/fairing.h"

namespace keypose {
namespace {

void RequireUsable(const MendStroke& stroke) {
  if (!(std::isfinite(stroke.radius) && stroke.radius > 0))
    throw InputError("its radius must be above 0");
  const double least = stroke.tool == MendTool::kPull ? -1 : 0;
  if (!(stroke.strength >= least && stroke.strength <= 1))
    throw InputError("its strength must be from " + std::string(least < 0 ? "-1" : "0") + " to 1");
  if (stroke.places.empty()) throw InputError("it has no place");
}

/// Where the brushed vertices go.
PointsX3 Moved(const Mesh& mesh, const MeshRings& rings, const PointsX3& points,
               const MendStroke& stroke, const Brushed& brushed) {
  const Eigen::Index count = std::ssize(brushed.vertices);
  PointsX3 before(count, 3), step(count, 3);
  for (Eigen::Index i = 0; i < count; ++i)
    before.row(i) = points.row(brushed.vertices[static_cast<std::size_t>(i)]);
  Eigen::VectorXd share = Eigen::VectorXd::Constant(count, stroke.strength);
  if (stroke.tool == MendTool::kFill)
    step = ThinPlate(mesh, rings, points, brushed.vertices) - before;
  else if (stroke.tool == MendTool::kSmooth)
    step = Faded(mesh, rings, points, brushed.vertices, stroke.radius) - before;
  else
    step = stroke.radius * brushed.directions;
  if (stroke.tool != MendTool::kFill)
    for (Eigen::Index i = 0; i < count; ++i)
      share[i] *= brushed.weights[static_cast<std::size_t>(i)];
  return before + share.asDiagonal() * step;
}

MendDone Apply(const Mesh& mesh, const MeshRings& rings, const MendStroke& stroke,
               PointsX3* points) {
  RequireUsable(stroke);
  const Brushed brushed = UnderBrush(mesh, rings, *points, stroke);
  MendDone done{static_cast<int>(brushed.vertices.size()), 0};
  if (done.vertices == 0) return done;
  const PointsX3 moved = Moved(mesh, rings, *points, stroke, brushed);
  if (!moved.allFinite()) throw InputError("the mesh has faces without area under it");
  for (Eigen::Index i = 0; i < moved.rows(); ++i) {
    auto point = points->row(brushed.vertices[static_cast<std::size_t>(i)]);
    done.furthest = std::max(done.furthest, (moved.row(i) - point).norm());
    point = moved.row(i);
  }
  return done;
}

}  // namespace

Mended Mend(const Mesh& mesh, const std::vector<MendStroke>& strokes, Progress* progress) {
  const MeshRings rings(mesh);
  Mended mended{mesh.points, {}};
  for (std::size_t i = 0; i < strokes.size(); ++i) {
    ReportProgress(progress, static_cast<double>(i) / static_cast<double>(strokes.size()),
                   "mending");
    const std::string name =
        "stroke " + std::to_string(i + 1) + " (" + NameOf(strokes[i].tool) + ")";
    try {
      mended.done.push_back(Apply(mesh, rings, strokes[i], &mended.points));
    } catch (const InputError& error) {
      throw InputError(name + ": " + error.what());
    } catch (const SolverError& error) {
      throw InputError(name + ": the mesh under it cannot be smoothed (" + error.what() +
                       "); take the stroke out");
    }
  }
  return mended;
}

}  // namespace keypose
