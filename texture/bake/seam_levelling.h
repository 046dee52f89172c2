// Colour shifts that match photographs where one is painted beside another, and that move them to
// the mean of all.
#pragma once

#include <vector>

#include "texture/bake/colour_samples.h"
#include "texture/bake/labels.h"

namespace keypose::texture {

/// A term that is added to a view's colours (linear light) at a vertex.
struct Shift {
  int view;
  Eigen::Vector3f color;
};

/// One shift for each vertex and each view that paints a face around it.
///
/// Minimises the sum of four terms: the squared jumps between any two views at the vertices where
/// they meet; 0.1 times the squared differences between the shifts of one view along its edges;
/// `to_mean` times the squared distances to the mean colour of all views; 1e-4 times the squared
/// shifts. Colours at a vertex are means over the ring of its faces. With to_mean = 0 this is seam
/// levelling as published. Otherwise the texture's large-scale colour is that of all views
/// together, and only detail finer than a ring of faces comes from one photograph. The system is
/// sparse and symmetric positive definite: one factorisation for the three channels.
/// Sources: Lempitsky, Ivanov, CVPR 2007; Waechter et al., ECCV 2014.
/// Departs: the term towards the mean.
std::vector<std::vector<Shift>> LevelSeams(const Mesh& mesh, const std::vector<FaceViews>& faces,
                                           const std::vector<int>& labels,
                                           const std::vector<std::vector<LabelShare>>& shares,
                                           double to_mean);

}  // namespace keypose::texture
