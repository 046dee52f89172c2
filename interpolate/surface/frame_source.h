// Where the frames between keys come from, whatever the method.
#pragma once

#include <string>
#include <vector>

#include "core/mesh.h"

namespace keypose::interpolation {

/// One frame as a source computes it.
struct ComputedFrame {
  PointsX3 points;
  double volume_move = 0;  ///< largest way of a vertex by the volume correction
  int on_table = 0;        ///< vertices that touch the table
};

/// What a source can tell of itself once frames were computed.
struct SourceReport {
  int degenerate_faces = 0;      ///< most, of any span; so too below
  double largest_turn = 0;       ///< of any face or tetrahedron relative to the body [rad]
  double largest_remainder = 0;  ///< [rad]
  double largest_tear = 0;       ///< volumetric only: how far neighbours' turns part [rad]
  /// neighbouring faces that part on the way by over 0.5 rad more than at the keys
  int torn_edges = 0;
  int loops_that_do_not_close = 0;  ///< of these, such as only a ring turned inside itself has
  bool differential = false;        ///< a span had no consistent rotation vectors
  int tetrahedra = 0;
  std::vector<std::string> notes;  ///< for a person
};

/// Computes moments between keys.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  /// @param ways  shares of the span's way, not 0 or 1: keys are their own frames
  virtual std::vector<ComputedFrame> At(int span, const std::vector<double>& ways) = 0;
  virtual SourceReport report() const { return {}; }
};

}  // namespace keypose::interpolation
