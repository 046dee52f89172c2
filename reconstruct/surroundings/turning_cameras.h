// First cameras of photographs before tripods, by the mat or disc that turns there with the figure.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "reconstruct/matching/colmap_database.h"
#include "reconstruct/matching/pair_list.h"

namespace keypose::reconstruct {

/// Photographs of which some are from one tripod.
struct BeforeTripods {
  std::vector<std::string> names;
  std::vector<Camera> lenses;  ///< of each photograph
  const std::vector<Features>& features;
  const std::vector<PairMatches>& matches;  ///< without those that stay in place before a tripod
  const std::vector<ImagePair>& pairs;      ///< from one tripod
};

struct TurningCameras {
  Scene scene;      ///< photographs whose print says how it is turned; no points
  int tripods = 0;  ///< before which a plane turns
};

/// Where the plane that turns is in each tripod's pictures, which matches tell at any turn; how far
/// each tripod is from it, by matches between tripods; and how far it is turned in each photograph,
/// by its print. Paint that hardly matches does for this, and a scale that matches itself.
/// @param pictures  RGB, by photograph, of any size
/// @param regions   by photograph; see FindPrintTurns
/// @return nothing where no tripod shows such a plane
/// Same bits for any thread count.
std::optional<TurningCameras> CamerasOverTurningPrint(const BeforeTripods& set,
                                                      const std::vector<Image8>& pictures,
                                                      const std::vector<Image8>& regions);

}  // namespace keypose::reconstruct
