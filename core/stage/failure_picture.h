// A picture that a stage leaves where it fails, so that a person sees why.
#pragma once

#include <filesystem>
#include <string_view>

#include "core/stage/stage.h"

namespace keypose {

/// Where to write it: beside the final place of an output, NAME.failed.jpg. It stays when the stage
/// fails, unlike the output; `keypose run` keeps it with the log of the failure, and corrects its
/// path in the error. A stage that succeeds leaves none: an old one is to be removed at its begin.
/// @pre the output was asked for
inline std::filesystem::path FailurePicture(StageContext& stage, std::string_view port) {
  // Outputs are made in a hidden folder next to their final place.
  const std::filesystem::path made = stage.Output(port);
  return made.parent_path().parent_path() / (made.filename().string() + ".failed.jpg");
}

}  // namespace keypose
