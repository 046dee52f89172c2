// As-rigid-as-possible frames through any number of keys: smooth paths of faces, one linear system,
// held regions, table and volume.
#pragma once

#include <memory>
#include <vector>

#include "interpolate/maps/face_maps.h"
#include "interpolate/surface/frame_source.h"
#include "interpolate/timing/rules.h"

namespace keypose::interpolation {

/// Vertices fitted to FacePaths' edges with one Laplacian, the sum over all keys. It is constant
/// over the timeline, because otherwise the vertices' pace would jump at a key where a face's
/// wanted edges cannot be met exactly. It is factored once for each set of regions that some span
/// holds.
///
/// Then, in this order: held regions and the parts' centroids are Lagrange constraints, on paths
/// that are smooth through the keys; the table; the volume of each closed part, whose logarithm
/// follows a path through the keys.
class KeySource final : public FrameSource {
 public:
  /// @throws InputError, SolverError  as MakeFrameSource
  KeySource(const std::vector<PointsX3>& keys, const FacesX3& faces, const Schedule& schedule,
            const Rules& rules, Stretch stretch = Stretch::kBalanced);
  ~KeySource() override;
  std::vector<ComputedFrame> At(int span, const std::vector<double>& ways) override;
  SourceReport report() const override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace keypose::interpolation
