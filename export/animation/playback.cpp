#include "export/animation/playback.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <utility>

namespace keypose::exporting {
namespace {

bool SameBits(const PointsX3& a, const PointsX3& b) {
  return a.rows() == b.rows() && std::memcmp(a.data(), b.data(), sizeof(double) * a.size()) == 0;
}

std::vector<int> FirstWithSamePoints(const std::vector<PointsX3>& points) {
  std::vector<int> first;
  std::map<double, std::vector<int>> by_sum;  // only frames with the same sum can be equal
  for (int i = 0; i < std::ssize(points); ++i) {
    std::vector<int>& rivals = by_sum[points[i].sum()];
    const auto same = std::find_if(rivals.begin(), rivals.end(),
                                   [&](int j) { return SameBits(points[j], points[i]); });
    first.push_back(same == rivals.end() ? i : *same);
    if (same == rivals.end()) rivals.push_back(i);
  }
  return first;
}

/// Pictures that repeat for several consecutive frames are held to their end.
std::vector<char> RepeatedStand(const std::vector<int>& picture) {
  std::vector<char> stands(picture.size(), 0);
  for (std::size_t i = 1; i < picture.size(); ++i)
    if (picture[i] == picture[i - 1]) stands[i] = stands[i - 1] = 1;
  return stands;
}

bool Changes(const std::vector<Moment>& moments, std::size_t i, const Clip& clip) {
  return clip.picture[moments[i].frame] != clip.picture[moments[i + 1].frame];
}

/// Time from a held picture's second keyframe to the step [s]: a thousandth of a frame, or more if
/// single precision needs it.
double GapBefore(double seconds, double fps) {
  const auto time = static_cast<float>(seconds);
  const double grain = time - std::nextafter(time, -std::numeric_limits<float>::infinity());
  return std::max(1e-3 / fps, 4 * grain);
}

}  // namespace

Clip MakeClip(const std::vector<PointsX3>& points, std::vector<char> stands, bool loop) {
  Clip clip;
  clip.picture = FirstWithSamePoints(points);
  clip.stands = stands.size() == points.size() ? std::move(stands) : RepeatedStand(clip.picture);
  clip.loop = loop;
  return clip;
}

std::vector<Moment> PlaybackMoments(const Clip& clip, const PlaybackOptions& options) {
  std::vector<Moment> moments;
  int tick = 0;
  const auto show = [&](int frame, int held, bool stands) {
    moments.push_back({tick / options.fps, frame, stands});
    if (held > 0) moments.push_back({(tick + held) / options.fps, frame, stands});
    tick += held + 1;
  };
  const int last = clip.frame_count() - 1;
  for (int i = 0; i <= last; ++i)
    show(i, i == 0 || i == last ? options.hold : 0, i < last && clip.stands[i]);
  // On the way back, the last moment is the first of the next round, so it is not held again.
  if (options.loop == "pingpong") {
    if (last > 0) moments.back().stands = clip.stands[last - 1];
    for (int i = last - 1; i >= 0; --i) show(i, 0, i > 0 && clip.stands[i - 1]);
  } else if (last > 0 && clip.stands[last - 1] && options.hold == 0 && !clip.loop) {
    moments.back().stands = true;
    show(last, 0, false);
  }
  return moments;
}

std::vector<Keyframe> LinearKeyframes(const std::vector<Moment>& moments, const Clip& clip,
                                      double fps) {
  std::vector<Keyframe> keyframes;
  for (std::size_t i = 0; i < moments.size(); ++i) {
    keyframes.push_back({moments[i].seconds, moments[i].frame});
    if (i + 1 == moments.size() || !moments[i].stands || !Changes(moments, i, clip)) continue;
    const double next = moments[i + 1].seconds;
    keyframes.push_back({next - GapBefore(next, fps), moments[i].frame});
  }
  // No keyframe is needed in the middle of a held picture.
  std::vector<Keyframe> needed;
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    const auto picture = [&](std::size_t k) { return clip.picture[keyframes[k].frame]; };
    const bool inside = i > 0 && i + 1 < keyframes.size() && picture(i - 1) == picture(i) &&
                        picture(i) == picture(i + 1);
    if (!inside) needed.push_back(keyframes[i]);
  }
  return needed;
}

std::vector<Keyframe> StepKeyframes(const std::vector<Moment>& moments, const Clip& clip) {
  std::vector<Keyframe> keyframes{{moments[0].seconds, moments[0].frame}};
  bool changes = false;
  for (std::size_t i = 0; i + 1 < moments.size(); ++i) {
    const bool change = Changes(moments, i, clip);
    if (change && !moments[i].stands) return {};
    changes |= change;
    if (change || i + 2 == moments.size())
      keyframes.push_back({moments[i + 1].seconds, moments[i + 1].frame});
  }
  return changes ? keyframes : std::vector<Keyframe>();
}

std::vector<int> FilmFrames(const std::vector<Moment>& moments, double fps) {
  std::vector<int> frames;
  for (std::size_t i = 0; i < moments.size(); ++i) {
    const auto tick = [&](const Moment& moment) { return std::llround(moment.seconds * fps); };
    // The last picture is shown for one frame, like all others. A moment that only ends its hold
    // adds no frame.
    const bool end_of_last = i > 0 && i + 1 == moments.size() && moments[i - 1].stands &&
                             moments[i - 1].frame == moments[i].frame;
    long count = end_of_last ? 0 : 1;
    if (i + 1 < moments.size()) count = tick(moments[i + 1]) - tick(moments[i]);
    frames.insert(frames.end(), static_cast<std::size_t>(count), moments[i].frame);
  }
  return frames;
}

}  // namespace keypose::exporting
