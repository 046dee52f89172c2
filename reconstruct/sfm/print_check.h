// Cameras that the print under the figure shows to be turned are placed again.
#pragma once

#include <vector>

#include "reconstruct/sfm/strategy.h"

namespace keypose::reconstruct {

/// What the print under the figure says of cameras.
struct PrintCheck {
  Scene scene;  ///< with the cameras turned as the print says
  int turned = 0, known = 0;
  int guests = 0;               ///< cameras without one before, which the print confirms
  std::vector<char> is_turned;  ///< by image of the set
};

/// Photographs at a size for comparing prints, and where each may show what carries the figure.
struct PrintPictures {
  std::vector<Image8> photographs;  ///< RGB, by image of the set
  std::vector<Image8> regions;      ///< by image of the set; see FindPrintTurns
};

PrintPictures PicturesForPrint(const ImageSet& set, const std::vector<Image8>& regions);

/// Compares what the photographs show of the plane under the figure, from above. Nothing is turned
/// where there is no plane, or no print on it. Photographs without a camera get one by what they
/// share of the plane with others, if their print then agrees at some turn.
PrintCheck CheckPrint(const StrategyContext& context, const PrintPictures& pictures,
                      const Scene& scene, const MatchedFeatures& matched);

/// Replaces the verified matches of photographs with cameras by the raw ones that fit these
/// cameras, in `matched` and in the database.
void KeepMatchesOf(const StrategyContext& context, const Scene& scene, const SfmFiles& files,
                   MatchedFeatures& matched);

/// Takes all verified matches of some photographs away, so that they are not placed.
void ForgetMatchesOf(const std::vector<char>& images, const SfmFiles& files,
                     MatchedFeatures& matched);

}  // namespace keypose::reconstruct
