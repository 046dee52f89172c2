// Frames through any number of keys as rigid as possible: smooth paths of faces, one linear system,
// held regions, table and volume.
#pragma once

#include <memory>
#include <vector>

#include "interpolate/maps/face_maps.h"
#include "interpolate/surface/frame_source.h"
#include "interpolate/timing/rules.h"

namespace keypose::interpolation {

/// Vertices fitted to FacePaths' edges with one Laplacian, the sum of all keys': constant over the
/// whole timeline, as a pace without jumps needs. (Where a face's wanted edges cannot be met
/// exactly, another matrix after a key would change the vertices' pace there.) It is factored once
/// for each set of regions that some span holds.
///
/// On top of it, in this order: held regions and the parts' centroids by Lagrange multipliers, on
/// paths smooth through keys; the table; each closed part's volume on the path of its logarithm
/// through the keys.
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
