// Pictures that a step left when it failed, so that a person sees why.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "studio/project/snapshot.h"

namespace keypose::studio {

/// A list of {step, picture, version}: another failure has another version. Empty once the step has
/// succeeded.
nlohmann::json FailurePicturesJson(Snapshot& snapshot, const pipeline::Step& step);

/// @param step  as its id
/// @throws UsageError  no such step
/// @throws NotFound    it left no such picture, or has succeeded since
std::filesystem::path FailurePictureFile(Snapshot& snapshot, const std::string& step,
                                         const std::string& name);

/// What a step said as it failed, without the clauses that only name the places of such pictures.
std::string WithoutPicturePaths(std::string said);

}  // namespace keypose::studio
