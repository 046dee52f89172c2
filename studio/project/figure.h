// What a person said the figure of a pose is, or the actor of a performance's shot: clicks and
// strokes in photographs or in frames of films, as the page shows them. `keypose figure` writes the
// same.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "studio/project/snapshot.h"

namespace keypose::studio {

/// - revision  of pipeline.yaml
/// - step      that is told; "" if none can be
/// - problem   why none can be, or what is wrong with the text in pipeline.yaml; or ""
/// - unclear   what a step of the pose says when its photographs do not tell what the figure is; or
/// ""
/// - sheet     the picture of all masks that the step made last, below out/; or ""
/// - refused   {step, picture, version}: what was taken for the figure when a step last refused it
///             (failure_pictures.h)
/// - follow    ids of the steps that come after it, and run again if its result changes
/// - strokes   {text, picture, figure, points, gone}; `picture` as the page calls it, of a shot
///             CAMERA/FRAME; `points` as shares of its width and height, as the page shows it;
///             `gone`: there is no such photograph any more
/// @param pose  or shot @throws UsageError  no such pose
nlohmann::json FigureJson(Snapshot& snapshot, const std::string& pose);

/// Writes what is said to pipeline.yaml.
/// @param body  {revision, strokes}: of those that stay only their `text`, of new ones picture,
///              figure and points
/// @return as FigureJson, of what is said now
/// @throws UsageError  no such pose, photograph or frame, a place outside of it, no step that can
/// be told
/// @throws ChangedMeanwhile
nlohmann::json SaveFigure(Snapshot& snapshot, const std::string& pose, const nlohmann::json& body);

}  // namespace keypose::studio
