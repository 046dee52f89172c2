// Interface of the methods that compute frames between keys.
#pragma once

#include <string>
#include <vector>

#include "core/values/mesh.h"

namespace keypose::interpolation {

/// One frame of a source.
struct ComputedFrame {
  PointsX3 points;
  double volume_move = 0;  ///< largest displacement of a vertex by the volume correction
  int on_table = 0;        ///< vertices that touch the table
};

/// What a source reports after frames were computed.
struct SourceReport {
  int degenerate_faces = 0;      ///< maximum over the spans; the values below as well
  double largest_turn = 0;       ///< of any face or tetrahedron relative to the body [rad]
  double largest_remainder = 0;  ///< [rad]
  double largest_tear = 0;       ///< volumetric only: largest difference of neighbours' turns [rad]
  /// pairs of neighbouring faces whose turns differ half-way by over 0.5 rad more than at the keys
  int torn_edges = 0;
  int loops_that_do_not_close = 0;  ///< torn edges that only a ring turned inside itself has
  bool differential = false;        ///< a span had no consistent rotation vectors
  int tetrahedra = 0;
  std::vector<std::string> notes;  ///< for the user
};

/// Computes moments between keys.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  /// @param ways  shares of the span's way, not 0 or 1: there the keys are the frames
  virtual std::vector<ComputedFrame> At(int span, const std::vector<double>& ways) = 0;
  virtual SourceReport report() const { return {}; }
};

}  // namespace keypose::interpolation
