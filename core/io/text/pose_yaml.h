// The poses in the text of a pipeline.yaml: added, renamed, taken out, put into another order. As
// yaml_edit.h: only what is changed changes; comments and order stay.
#pragma once

#include <string>
#include <vector>

#include "core/io/text/yaml_place.h"

namespace keypose {

/// With fewer photographs, a pose other than the template is not scanned: the template is bent into
/// them (`method: fit`). Decided once, when a pose is added, so that more photographs later never
/// change the way by themselves.
inline constexpr int kFewestOfAScan = 16;

/// The names of the poses, in the order of the file.
std::vector<std::string> PosesIn(const std::string& text);
/// Whether the timeline says no more than the poses' own order: each once, or nothing at all.
bool TimelineOnlyListsPoses(const std::string& text);

/// With a pose at the end, whose photographs are in photos/POSE. The first one becomes the
/// template. A timeline that only lists the poses gets it at its end.
/// @param few  it gets few photographs, which the template is bent into: `method: fit`
/// @throws YamlEditError  it cannot be edited so, or has the pose already
std::string WithPose(const std::string& text, const std::string& pose, bool few);

/// With another name for a pose, everywhere: its key, the template, keys of the timeline, frames of
/// the filmed shot.
/// @throws YamlEditError  there is no such pose, or one of the new name
std::string WithPoseRenamed(const std::string& text, const std::string& pose,
                            const std::string& name);

/// Without a pose, its keys on the timeline and its frames of the filmed shot. A timeline that
/// would only list one pose goes too.
/// @throws YamlEditError  there is no such pose
std::string WithoutPose(const std::string& text, const std::string& pose);

/// With a pose that WithoutPose took out of `before`: `before` itself where nothing has changed
/// since; else the pose comes last, with its keys where the timeline is as it was left, and its
/// frames of the filmed shot where these show no other pose by now.
/// @throws YamlEditError  it cannot be edited so, or has the pose already
std::string WithPoseBack(const std::string& text, const std::string& pose,
                         const std::string& before);

/// With the poses in another order, each with the comments before it; a timeline that only lists
/// them follows.
/// @param order  all of them
/// @throws YamlEditError  they are others
std::string WithPoseOrder(const std::string& text, const std::vector<std::string>& order);

/// The pose whose mesh all others get: `template`, else the first; "" if there is none.
std::string TemplateIn(const std::string& text);
/// "fit" or "scan" as the pose says, "" if it says nothing.
std::string MethodIn(const std::string& text, const std::string& pose);
/// With a way to find a pose; "" takes it out.
/// @throws YamlEditError  there is no such pose
std::string WithMethod(const std::string& text, const std::string& pose, const std::string& method);

/// The value of a pose as one line of YAML, to be put back with WithValue.
std::string PoseValue(const std::string& text, const std::string& pose);

}  // namespace keypose
