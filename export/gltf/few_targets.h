// Animated meshes as binary glTF 2.0 with few morph targets, as game engines limit them.
#pragma once

#include <string>
#include <vector>

#include "core/values/progress.h"
#include "export/gltf/glb_options.h"

namespace keypose::exporting {

struct FewTargetsOptions {
  int max_targets = 8;        ///< most morph targets, 1 to 255
  double error_bound = 1e-5;  ///< largest distance of a vertex, as share of the diagonal, > 0
  std::string file = "character_few.glb";
  std::vector<std::string> Problems() const;
};

/// `file`: as MakeGlb, but the targets are not pictures. They are the shapes whose
/// weighted sums come closest to all pictures: as few as keep every vertex within `error_bound`,
/// or `max_targets` with the smallest largest error. One LINEAR track of weights has a keyframe
/// for each of SceneKeyframes, so between two frames all moves in a straight line as in MakeGlb,
/// and the error is not larger there than at the frames. Weights are in [0, 1]. Without an
/// animation the first frame is shown. If the motion allows it (see MakeUnitWeights), the base is
/// the first frame too. The targets' normals are fitted to the normals of the blended pictures.
///
/// `measured`, each of the numbers as written and over all pictures: `morph_targets`;
/// `error_bound`; `rms_over_diagonal`; `worst_frame`, which has the largest error;
/// `volume_error`, the largest change of a frame's volume, over the first frame's;
/// `normal_rms_deg`; `picture_targets_error_over_diagonal`, what as many pictures as targets
/// would have given; `base_is_first_frame`, 1 or 0.
///
/// @param textures  as for MakeGlb
/// @throws UsageError  options.Problems()
/// @throws InputError  as MakeGlb
FormatFiles MakeFewTargetsGlb(const Scene& scene, const GlbTextures& textures,
                              const FewTargetsOptions& options, Progress* progress);

}  // namespace keypose::exporting
