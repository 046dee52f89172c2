// What one frame of a film says about the place of the mesh, at one size of the picture.
#pragma once

#include <vector>

#include "composite/locating/appearance/grey_term.h"
#include "composite/locating/candidates/feature_search.h"
#include "composite/locating/clicks/clicked_place.h"
#include "composite/locating/outline/outline_matches.h"

namespace keypose::composite {

struct PictureEvidence {
  double scale = 1;  ///< of this size over the whole picture's
  ImageF luma;       ///< empty: grey values and edges are not used
  Image8 matte;      ///< empty: outlines are not used
  MatteOutline outline{Image8{}};
  double matte_deviation_px = 0.6;  ///< of the matte's outline, at this size
  std::vector<Sighting> sightings;  ///< pixels of this size
  std::vector<Click> clicks;        ///< likewise
};

/// @param picture   RGB
/// @param matte     1 channel of the same size, or empty
/// @param deviation_px  of the matte's outline in the whole picture
PictureEvidence MakeEvidence(const Image8& picture, const Image8& matte, double deviation_px,
                             double scale);
/// With the pixels of sightings and clicks in the whole picture.
void SetSightings(PictureEvidence& evidence, const std::vector<Sighting>& sightings);
void SetClicks(PictureEvidence& evidence, const std::vector<Click>& clicks);

/// What is known of the lens beforehand.
struct LensPrior {
  double focal_px = 0;         ///< in the whole picture; the deviation below says how surely
  double focal_deviation = 0;  ///< of its logarithm; 0: fixed
  bool focal_free = false, k1_free = false;
  /// px of the whole picture: of what mattes lie outside of the figure all round; 0: it is known.
  double matte_offset_deviation = 0;
};

/// Which terms are used.
struct Terms {
  double reach_px = 10;                  ///< beyond it, outlines are not compared
  const GreyTexture* texture = nullptr;  ///< null: grey values are not compared
  bool edges = false;                    ///< inner outlines against edges of the picture
  double matte_offset_px = 0;            ///< by which mattes lie outside of the figure all round
};

/// The equations of one frame, without the lens's prior.
/// @param center, radius  of the mesh that turns; those of the figure unless several share a step
NormalEquations EquationsOf(const Figure& figure, const PictureEvidence& evidence,
                            const Placement& at, const Terms& terms, const Eigen::Vector3d& center,
                            double radius);
NormalEquations EquationsOf(const Figure& figure, const PictureEvidence& evidence,
                            const Placement& at, const Terms& terms);

/// @param matte_offset_px  that the equations were made with
void AddLensPrior(NormalEquations& equations, const LensPrior& prior, double scale,
                  double matte_offset_px = 0);

/// A sum of truncated squares over outlines, sightings and clicks, in units of their variance: the
/// same for all placements of one frame, so that they can be compared.
/// @param matte_offset_px  as in Terms
struct Misfit {
  double cost = 0;
  double count = 0;  ///< of independent residuals
};
Misfit MisfitOf(const Figure& figure, const PictureEvidence& evidence, const Placement& at,
                double reach_px, double matte_offset_px = 0);

/// The equations that outlines alone give, from smooth normals: a turn that they do not see at all,
/// as about the axis of a vase, has no part in them.
NormalEquations SmoothOutlineEquations(const Figure& figure, const Placement& at);

}  // namespace keypose::composite
