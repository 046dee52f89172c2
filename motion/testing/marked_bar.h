// A bar that is moved by marks.
#pragma once

#include <string>
#include <vector>

#include "core/surfaces/shapes.h"
#include "core/values/size_of.h"
#include "motion/testing/rigged_scan.h"
#include "motion/transfer.h"

namespace keypose::motion {

inline Mark OnBoth(int face, const std::string& name = "") {
  Mark mark;
  mark.name = name.empty() ? "mark-" + std::to_string(face) : name;
  mark.on_template.face = mark.on_target.face = face;
  return mark;
}

inline std::vector<PointsX3> Transferred(const Mesh& target, const PointsX3& reference,
                                         const FacesX3& faces, const std::vector<Mark>& marks,
                                         const std::vector<PointsX3>& frames,
                                         const TransferOptions& options) {
  Transfer transfer(target, reference, faces, marks, options);
  for (int t = 0; t < SizeOf(frames); ++t) transfer.Add(frames[t], "frame " + std::to_string(t));
  std::vector<PointsX3> result;
  transfer.Run([&](int, const PointsX3& points) { result.push_back(points); });
  return result;
}

/// A bar along z with a square section, finely cut along it.
inline Mesh MakeBar(int rings = 60) { return MakeCylinder(0.05, 2, 12, rings); }

inline std::vector<Mark> MarksAlong(const Mesh& bar, const std::vector<double>& heights) {
  std::vector<Mark> marks;
  for (double z : heights)
    marks.push_back(OnBoth(FaceNear(bar, {0.05, 0, z}), "at-" + std::to_string(z)));
  return marks;
}

}  // namespace keypose::motion
