#include "export/playback.h"

namespace keypose::exporting {

std::vector<Moment> PlaybackMoments(int frame_count, const PlaybackOptions& options) {
  std::vector<Moment> moments;
  int tick = 0;
  const auto show = [&](int frame, int held) {
    moments.push_back({tick / options.fps, frame});
    if (held > 0) moments.push_back({(tick + held) / options.fps, frame});
    tick += held + 1;
  };
  const int last = frame_count - 1;
  for (int i = 0; i <= last; ++i) show(i, i == 0 || i == last ? options.hold : 0);
  // The last moment back at the first frame is the first moment of the next round, so it is not held again.
  if (options.loop == "pingpong") {
    for (int i = last - 1; i >= 0; --i) show(i, 0);
  }
  return moments;
}

}  // namespace keypose::exporting
