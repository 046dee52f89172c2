#include "motion/bvh_rig/rigged_mesh.h"

#include <algorithm>

#include "core/numbers/parallel.h"
#include "core/values/size_of.h"
#include "core/values/union_find.h"

namespace keypose::motion {

int RiggedMesh::Find(const std::string& name) const {
  for (int b = 0; b < SizeOf(bones); ++b)
    if (bones[b].name == name) return b;
  return -1;
}

PointsX3 Skinned(const RiggedMesh& rig, const std::vector<BoneMove>& moves) {
  PointsX3 points(rig.mesh.points.rows(), 3);
  ParallelFor(
      points.rows(),
      [&](std::int64_t i) {
        const Eigen::Vector3d rest = rig.mesh.points.row(i);
        const auto moved = [&](int b) -> Eigen::Vector3d {
          return moves[b].turn * (rest - rig.bones[b].head) + moves[b].head;
        };
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (const auto& [bone, weight] : rig.weights[i]) sum += weight * moved(bone);
        points.row(i) = rig.weights[i].empty() ? moved(0) : sum;
      },
      512);
  return points;
}

RiggedMesh LargestPart(const RiggedMesh& rig) {
  const FacesX3& faces = rig.mesh.faces;
  UnionFind joined(rig.mesh.points.rows());
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 1; k < 3; ++k) joined.Join(faces(f, 0), faces(f, k));
  std::vector<int> size(rig.mesh.points.rows(), 0);
  for (Eigen::Index f = 0; f < faces.rows(); ++f) ++size[joined.Find(faces(f, 0))];
  const int largest = static_cast<int>(std::max_element(size.begin(), size.end()) - size.begin());
  RiggedMesh part;
  part.bones = rig.bones;
  std::vector<int> place(rig.mesh.points.rows(), -1), kept;
  for (int i = 0; i < SizeOf(place); ++i)
    if (joined.Find(i) == largest) {
      place[i] = SizeOf(kept);
      kept.push_back(i);
    }
  part.mesh.points.resize(std::ssize(kept), 3);
  for (int k = 0; k < SizeOf(kept); ++k) {
    part.mesh.points.row(k) = rig.mesh.points.row(kept[k]);
    part.weights.push_back(rig.weights[kept[k]]);
  }
  part.mesh.faces.resize(size[largest], 3);
  Eigen::Index at = 0;
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    if (place[faces(f, 0)] >= 0) {
      for (int k = 0; k < 3; ++k) part.mesh.faces(at, k) = place[faces(f, k)];
      ++at;
    }
  return part;
}

}  // namespace keypose::motion
