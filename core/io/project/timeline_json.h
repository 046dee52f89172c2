// Reads timelines.
#pragma once

#include <optional>
#include <string>

#include "core/values/errors.h"
#include "core/values/timeline.h"

namespace keypose {

/// The Ease with this name: linear, ease, in, out, in-out (the CSS curves of these names). None for
/// another name.
std::optional<Ease> EaseNamed(const std::string& name);

/// An error in a timeline, with the index of the key that it is about; -1 when it is not about a
/// key.
struct TimelineError : InputError {
  TimelineError(const std::string& message, int key_index) : InputError(message), key(key_index) {}
  int key;
};

/// Reads {"schema": 2, "fps": 24, "keys": [{"pose": "rest", "time": 0}, ...], ...};
/// docs/file-formats.md has all fields. Schema 1 (fps, pose and time only) is read too.
///
/// @param source  the timeline's name in messages
/// @throws TimelineError  malformed, an unknown field (with the nearest known one), a value out of
/// range, keys that are not in order of time, a hold that does not end before the next key, or a
/// region that does not exist; names key and field
Timeline ParseTimeline(const std::string& json, const std::string& source);

/// What `interpolate` would refuse once the keys' meshes are there, as far as poses and times tell
/// it: for programs that know a project's timeline an hour before.
///
/// @param timeline  its keys name their poses
/// @throws TimelineError  a loop that does not end with its first pose, two keys in one frame, or a
/// pin from or to a time without a key
void RequirePlayable(const Timeline& timeline, const std::string& source);

}  // namespace keypose
