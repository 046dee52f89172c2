// Photographs that show another thing than the others, while `capture` reads them.
#pragma once

#include <string>
#include <vector>

#include "capture/photograph_import.h"

namespace keypose::capture {

/// A photograph that is not used.
struct SetAside {
  std::string name, why;  ///< why: for the user
  Image8 small;           ///< its working image
};

/// Takes photographs out of the import that show another thing than the others of their placement,
/// where those are at most a quarter, and says so; what is learned from the others is as without
/// them. Those stay that a person has given a mask or strokes for. Where options keep them, they
/// stay and are only told of. Tells of views that are there twice, too.
/// @pre import.small has the working images
/// @throws InputError  more than a quarter, in groups of three or more: names them; fewer than
/// options.min_images are left
std::vector<SetAside> SetOtherThingsAside(StageContext& stage, PhotographImport* import,
                                          const CaptureOptions& options);

}  // namespace keypose::capture
