#include "motion/root/patch_paths.h"

#include <algorithm>
#include <numeric>

#include "core/numbers/kd_tree.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/size_of.h"
#include "deform/levels/edge_collapse.h"

namespace keypose::motion {

namespace {

constexpr int kCopyVertices = 2500;
constexpr int kFramesTogether = 24;

}  // namespace

SmallCopy CopyOf(const PointsX3& points, const FacesX3& faces) {
  DecimatedMesh mesh = ToDecimatedMesh(points, faces);
  std::vector<int> parent(points.rows());
  std::iota(parent.begin(), parent.end(), 0);
  if (SizeOf(mesh.vertex) > kCopyVertices) DecimateInRounds(mesh, kCopyVertices, parent);
  SmallCopy copy{mesh.points, FacesX3(std::ssize(mesh.faces), 3)};
  for (int f = 0; f < SizeOf(mesh.faces); ++f)
    copy.faces.row(f) << mesh.faces[f][0], mesh.faces[f][1], mesh.faces[f][2];
  return copy;
}

std::vector<PointsX3> TrackPatches(const SmallCopy& copy, const PointsX3& target,
                                   const FacesX3& faces, const std::vector<Mark>& marks,
                                   const PointsX3& centres, const std::vector<MotionFrame>& frames,
                                   const RootPath& path) {
  const RayScene scene(copy.points, copy.faces);
  std::vector<MarkPlace> places;
  std::vector<int> marked;
  for (const Mark& mark : marks) {
    const RayScene::Foot foot =
        scene.ClosestPoint(PositionOf(mark.on_target, target, faces).transpose());
    places.push_back({foot.face, foot.barycentric});
    marked.push_back(foot.face);
  }
  const MarkFields fields(copy.points, copy.faces, marked, {true, 1e-4});
  const PlacedPoses placed(copy.points, copy.faces, places, fields, path,
                           FrameSolver::SystemOf(copy.points, copy.faces, true), true);
  const KdTree tree(copy.points);
  std::vector<int> carrier;
  for (Eigen::Index p = 0; p < centres.rows(); ++p)
    carrier.push_back(tree.Nearest(centres.row(p).transpose()).index);
  std::vector<PointsX3> tracks(centres.rows(), PointsX3(std::ssize(frames), 3));
  for (int first = 0; first < SizeOf(frames); first += kFramesTogether) {
    const int count = std::min(kFramesTogether, SizeOf(frames) - first);
    const std::vector<PointsX3> poses = placed.Make(std::span(frames).subspan(first, count));
    for (int k = 0; k < count; ++k)
      for (Eigen::Index p = 0; p < centres.rows(); ++p) {
        const Eigen::RowVector3d offset = centres.row(p) - copy.points.row(carrier[p]);
        tracks[p].row(first + k) =
            poses[k].row(carrier[p]) +
            offset * placed.solver().RotationAt(carrier[p], frames[first + k].fields).transpose();
      }
  }
  return tracks;
}

}  // namespace keypose::motion
