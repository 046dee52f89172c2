// Which puppet a take was recorded with, where no session of the studio has kept that: takes of the
// command line, of another machine, from before.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace keypose::studio {

/// A set-up with the files below the folder 'armature' that fit the take: as `keypose armature
/// files` finds them; those of the last session, if they are among these. Beside them lie mesh,
/// texture, plate, camera and set, if they are called so: STEM.ply and STEM.png, where the skeleton
/// is STEM.bvh; plate.png, shot.json, set.ply.
/// @param last  the last session's set-up, or null
/// @throws UsageError  nothing fits
nlohmann::json PuppetOfTake(const std::filesystem::path& project, const std::string& take,
                            const nlohmann::json& last);

}  // namespace keypose::studio
