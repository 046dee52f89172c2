// Picks in the photographs of a pose that the template is bent into (`method: fit`): read, checked,
// saved, and compared with what the last fit made of them.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "studio/project/snapshot.h"

namespace keypose::studio {

/// {"pose", "revision", "picks": [], "pixels": [{name, image, pixel, photograph}], "problems":
/// [{name, text}]}. `photograph`: SHA-256 of the captured photograph that was picked in, where it
/// is known.
/// @throws UsageError  no such pose
nlohmann::json PhotoPicksJson(Snapshot& snapshot, const std::string& pose);

/// Writes the file that the pipeline takes for the pose's picks: the one that pipeline.yaml names,
/// else landmarks/POSE.json. What the page does not show, such as places in space, stays. A file
/// that would be empty is removed.
/// Picks that are new or were moved are noted as made in the photograph that is captured now; the
/// others stay noted as they are, unless the body says of which `photograph` they are.
/// @param body  {"pixels": [{name, image, pixel[, photograph]}], "revision": ...}
/// @throws ChangedMeanwhile
/// @throws UsageError  a wrong pick, or a file outside of the project
/// @throws InputError  the file has something that cannot be read, and would be lost
void SavePhotoPicks(Snapshot& snapshot, const std::string& pose, const nlohmann::json& body);

/// The pose's photographs, and what is known of picks in them. Pixels are those of the full size.
///
///   photographs [{name, width, height, photograph, shot_again, placed, iou, worst}]  SHA-256 as
///                                captured; whether there is a newer one; `worst`: where the
///                                outlines of the fitted model and of the mask are farthest apart,
///                                or null
///   shown   [{name, image, pixel, hidden}]  where the fitted model has each of the template's
///   picks lines   [{name, image, points}]         a name picked in one photograph: where others
///   may show it meets   [{name, image, pixel}]          picked in two or more: where all
///   photographs should refused [{name, image}]                 picks that the last fit left out
///
/// Photographs that capture has not read are left out. Without a fit only these are there.
/// @throws UsageError  no such pose, or it is no pose of few photographs
nlohmann::json PhotoFitJson(Snapshot& snapshot, const std::string& pose);

}  // namespace keypose::studio
