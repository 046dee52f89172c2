#include "interpolate/timing/spline.h"

#include <cmath>

#include "core/values/size_of.h"
#include "interpolate/timing/easing.h"

namespace keypose::interpolation {

SpanPace PaceOf(const Span& span) {
  if (span.frames == 0) return {};
  return {SlopeAtStart(span.ease) / span.frames, SlopeAtEnd(span.ease) / span.frames};
}

KeyMeeting MeetingAt(const Schedule& schedule, int key) {
  const int spans = SizeOf(schedule.spans);
  const bool at_end = key == 0 || key == spans, open = at_end && !schedule.loop;
  const int before = key > 0 ? key - 1 : spans - 1, after = key < spans ? key : 0;
  const bool has_before = !(open && key == 0), has_after = !(open && key == spans);
  int hold = has_after ? schedule.spans[after].hold : 0;
  if (key == spans || (schedule.loop && key == 0)) hold += schedule.end_hold;
  const auto is = [&](bool has, int span, Travel travel) {
    return has && schedule.spans[span].travel == travel;
  };
  KeyMeeting meeting;
  if (is(has_before, before, Travel::kSmooth)) {
    if (hold > 0 || is(has_after, after, Travel::kStepped))
      meeting.before = Meeting::kStill;
    else if (is(has_after, after, Travel::kSmooth))
      meeting.before = Meeting::kSmooth;
  }
  if (is(has_after, after, Travel::kSmooth)) {
    if (hold > 0)
      meeting.after = Meeting::kStill;
    else if (is(has_before, before, Travel::kSmooth))
      meeting.after = Meeting::kSmooth;
  }
  return meeting;
}

bool AnySmooth(const Schedule& schedule) {
  for (int key = 0; key <= std::ssize(schedule.spans); ++key) {
    const KeyMeeting meeting = MeetingAt(schedule, key);
    if (meeting.before != Meeting::kFree || meeting.after != Meeting::kFree) return true;
  }
  return false;
}

}  // namespace keypose::interpolation
