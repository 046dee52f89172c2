#include "interpolate/timing/frame_schedule.h"

#include <cmath>

#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "interpolate/timing/easing.h"

namespace keypose::interpolation {

namespace {

constexpr double kMostFrames = 1e6;

std::string NameOf(const Timeline& timeline, std::size_t key) {
  return "key " + std::to_string(key) +
         (timeline.keys[key].pose.empty() ? "" : " ('" + timeline.keys[key].pose + "')");
}

/// Number of frames from each key to the next, hold included.
std::vector<int> FramesBetweenKeys(const Timeline& timeline, int steps, const std::string& name) {
  std::vector<int> between;
  double total = 0;
  for (std::size_t k = 0; k + 1 < timeline.keys.size(); ++k) {
    double frames = steps + 1 + std::round(timeline.keys[k].hold_s * timeline.fps);
    if (timeline.has_times()) {
      const double start = *timeline.keys[0].time_s;
      frames = std::round((*timeline.keys[k + 1].time_s - start) * timeline.fps) -
               std::round((*timeline.keys[k].time_s - start) * timeline.fps);
    }
    if (!(frames >= 1))
      throw InputError(name + ": " + NameOf(timeline, k + 1) + " must come at least one frame (1/" +
                       std::to_string(timeline.fps) + " s) after the key before it");
    total += frames;
    if (!(total <= kMostFrames))
      throw InputError(name + ": " + NameOf(timeline, k + 1) +
                       " comes more than a million frames after the first");
    between.push_back(static_cast<int>(frames));
  }
  return between;
}

/// Adds frames one by one.
class Planner {
 public:
  explicit Planner(Schedule& schedule) : schedule_(schedule) {}

  void Key(int span, double way, int key) {
    schedule_.key_frames.push_back(Next());
    Add({span, way, key});
  }
  void Repeat(int frame, int count) {
    for (int j = 0; j < count; ++j) {
      PlannedFrame copy = schedule_.frames[frame];
      copy.same_as = frame;
      Add(copy);
    }
  }
  /// In-betweens of a span whose first key is at frame `key_frame`.
  void Way(int index, const Span& span, int step, int key_frame) {
    if (span.frames == 0) return;
    if (span.travel == Travel::kStepped) return Repeat(key_frame, span.frames - 1);
    int standing = key_frame;
    for (int j = 1; j < span.frames; ++j) {
      if (j % step != 0) {
        Repeat(standing, 1);
        continue;
      }
      standing = Next();
      Add({index, EaseAt(span.ease, static_cast<double>(j) / span.frames)});
    }
  }
  /// Marks the frames from `first` on as unchanged until the next one.
  void Stand(int first) {
    for (int f = first; f < Next(); ++f) schedule_.frames[f].stands = true;
  }
  int Next() const { return SizeOf(schedule_.frames); }

 private:
  void Add(PlannedFrame frame) {
    frame.time_s = schedule_.start_s + Next() / schedule_.fps;
    schedule_.frames.push_back(frame);
  }
  Schedule& schedule_;
};

}  // namespace

Schedule MakeSchedule(const Timeline& timeline, int key_count, int steps, const std::string& name) {
  const int count = SizeOf(timeline.keys);
  if (count != key_count)
    throw InputError(name + ": has " + std::to_string(count) + " keys, but " +
                     std::to_string(key_count) + " key meshes were given");
  const std::vector<int> between = FramesBetweenKeys(timeline, steps, name);
  Schedule schedule;
  schedule.fps = timeline.fps;
  schedule.start_s = timeline.has_times() ? *timeline.keys[0].time_s : 0;
  schedule.loop = timeline.loop;
  schedule.overshoot = timeline.overshoot;
  Planner plan(schedule);
  for (int k = 0; k + 1 < count; ++k) {
    const TimelineKey& key = timeline.keys[k];
    Span span;
    span.hold = std::min(static_cast<int>(std::round(key.hold_s * timeline.fps)), between[k]);
    span.frames = between[k] - span.hold;
    span.travel = span.frames == 0 ? Travel::kStepped : key.travel;
    span.ease = key.ease;
    span.turns = key.turns;
    const int key_frame = plan.Next();
    plan.Key(k, 0, k);
    // When the key is held until the next one, the hold ends one frame before it.
    plan.Repeat(key_frame, span.frames == 0 ? span.hold - 1 : span.hold);
    const int leaves = plan.Next() - 1;
    plan.Way(k, span, key.step, key_frame);
    if (span.travel == Travel::kStepped || key.step > 1) plan.Stand(leaves);
    schedule.spans.push_back(span);
  }
  const int last = plan.Next();
  plan.Key(count - 2, 1, count - 1);
  const double hold = std::round(timeline.keys.back().hold_s * timeline.fps);
  if (last + hold > kMostFrames)
    throw InputError(name + ": " + NameOf(timeline, count - 1) +
                     " holds for more than a million frames");
  schedule.end_hold = static_cast<int>(hold);
  plan.Repeat(last, schedule.end_hold);
  return schedule;
}

Schedule MakeSchedule(const std::vector<int>& in_betweens) {
  Timeline timeline;
  timeline.keys.resize(in_betweens.size() + 1);
  double frame = 0;
  for (std::size_t k = 0; k < timeline.keys.size(); ++k) {
    timeline.keys[k].time_s = frame / timeline.fps;
    if (k < in_betweens.size()) frame += in_betweens[k] + 1;
  }
  return MakeSchedule(timeline, SizeOf(timeline.keys), 0, "interpolate");
}

}  // namespace keypose::interpolation
