// From a closed mesh to a texture layout: charts that are nearly flat, packed into the unit square.
#pragma once

#include "core/values/mesh.h"
#include "core/values/options.h"
#include "core/values/progress.h"
#include "texture/unwrap/layout_check.h"

namespace keypose::texture {

struct UnwrapOptions {
  int texture_size = 2048;  ///< [px] edge of the square texture that the gutter is meant for
  int gutter = 4;           ///< [px] least distance between two charts; half of it to the border
  double max_distortion = 1.12;  ///< charts merge while their mean of max(s1, 1/s2) stays below,
                                 ///< and are cut when it is above; before elastic packing
  int effort = 600;  ///< moves in the search for places, in units of 16; cost grows with it
  /// smaller charts are tried while a smaller share of the texture is covered
  double enough_utilisation = 0.82;
  bool elastic_packing = true;  ///< charts deform a little where that fills gaps between them
  bool hide_seams = true;       ///< seams are placed where they are least visible: creases, below,
                                ///< behind (up is +z, the front -y)
  void Describe(OptionVisitor& visit);
};

struct UnwrapResult {
  Mesh mesh;  ///< the input's vertices and faces in their order, with UVs
  int charts = 0;
  AtlasStretch stretch;
  double seam_over_diag = 0;        ///< length of all seams over the diagonal
  double seam_front_over_diag = 0;  ///< ... of those in view from the front
  double seam_exposure = 0;         ///< mean of Exposure::seen along the seams
  double edge_exposure = 0;         ///< ... along all edges: the expected value of random seams
  double texels_per_unit = 0;       ///< texture pixels along one unit of the surface, on average
};

/// @param clean  closed oriented 2-manifold
/// @throws InputError    empty, not finite, not closed, or a face without area; names the place
/// @throws QualityError  the charts do not fit the texture with this gutter
/// Before it is returned, the layout is proven free of flipped and overlapping triangles in exact
/// arithmetic.
/// Same bits for any thread count.
/// Cost: some three processor seconds for 20,000 faces.
/// Source: chart growing Sander et al., SGP 2003; flattening Liu et al., SGP 2008; places Egeblad
/// et al., EJOR 2007; borders by minimal cuts; merging, elastic packing and proof are ours.
UnwrapResult Unwrapped(const Mesh& clean, const UnwrapOptions& options,
                       Progress* progress = nullptr);

}  // namespace keypose::texture
