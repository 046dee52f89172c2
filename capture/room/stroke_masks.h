// What a person's strokes say of one photograph.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/values/image.h"

namespace keypose::capture {

/// Strokes in one photograph at working size.
struct ViewStrokes {
  std::vector<Eigen::Vector2i> figure, other;  ///< pixels
  bool empty() const { return figure.empty() && other.empty(); }
};

/// The mask of the thing under the strokes. Of what the network saw, the parts that a stroke of the
/// figure touches, if no other stroke touches them too; else the photograph is segmented by its
/// colours, from the strokes outwards.
/// @param salience  of the photograph's size, or empty
/// @return empty where only other things are marked and the network saw nothing
Image8 MaskOfStrokes(const Image8& rgb, const Image8& salience, const ViewStrokes& strokes);

/// Whether what the network saw under a person's strokes holds as well what the person said is not
/// the figure: the network takes both for one thing, in other photographs too.
/// @param salience  of the photograph; may be empty
bool TakesBothForOne(const Image8& salience, const ViewStrokes& strokes);

}  // namespace keypose::capture
