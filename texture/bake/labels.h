// One photograph per face: nearly the best everywhere, with few and inconspicuous borders.
#pragma once

#include <vector>

#include "core/values/mesh.h"

namespace keypose::texture {

/// A photograph from which a face may be painted.
struct LabelCandidate {
  int view;
  double quality;  ///< > 0; footprint, angle, sharpness, trust, agreement with the other views
  Eigen::Vector3f color;     ///< mean colour of the face in it, square root of linear light
  Eigen::Vector3f linear;    ///< the same in linear light
  float seen;                ///< share of the face that the view sees, in (0, 1]
  float agreement;           ///< with the other views, the least over the face, in (0, 1]
  float weight = 0;          ///< weight of this view in the mean of all, at full trust
  float mean_agreement = 1;  ///< over the face: part of the weight
};

struct LabelOptions {
  int most_candidates = 8;  ///< at most this many best views per face
  int sweeps = 4;           ///< largest number of rounds over all views
};

/// The view of each face, -1 where there is no candidate.
///
/// Minimises  sum_f area_f ln(best_f / quality_f)  +  kSmoothness sum_e length_e h (1 + |colour
/// difference along e| / kColorStep)  over labelings, with h the mean edge, by alpha-expansion;
/// each step is an exact minimum cut. Never worse than each face's best view by itself.
/// Same bits for any thread count.
/// Source: Boykov, Veksler, Zabih, PAMI 2001; Kolmogorov, Zabih, PAMI 2004 (the graph); Lempitsky,
/// Ivanov, CVPR 2007 (the use).
std::vector<int> ChooseLabels(const Mesh& mesh, std::vector<std::vector<LabelCandidate>> candidates,
                              const LabelOptions& options = {});

/// The candidate of a view in an ascending list; null if there is none.
const LabelCandidate* FindCandidate(const std::vector<LabelCandidate>& ascending, int view);

/// Shares of the views around each vertex, by the area of its faces; sums to 1 where any face has a
/// label. Views ascending.
struct LabelShare {
  int view;
  float share;
};
std::vector<std::vector<LabelShare>> VertexShares(const Mesh& mesh, const std::vector<int>& labels);

}  // namespace keypose::texture
