#include "export/animation/scene.h"

#include <algorithm>

#include "core/surfaces/geometry.h"

namespace keypose::exporting {

std::string EncodedImage::FileName(int number) const {
  return "texture_" + std::to_string(number) + (mime_type == "image/png" ? ".png" : ".jpg");
}

std::vector<int> ShownFrames(const Scene& scene) {
  return FilmFrames(PlaybackMoments(scene.clip, scene.playback), scene.playback.fps);
}

bool Loops(const Scene& scene) { return scene.clip.loop || scene.playback.loop == "pingpong"; }

std::vector<int> RoundOf(const Scene& scene) {
  std::vector<int> round = ShownFrames(scene);
  if (Loops(scene) && round.size() > 1) round.pop_back();
  return round;
}

std::vector<Keyframe> SceneKeyframes(const Scene& scene) {
  return LinearKeyframes(PlaybackMoments(scene.clip, scene.playback), scene.clip,
                         scene.playback.fps);
}

std::vector<double> KeySeconds(const Scene& scene) {
  const auto moments = PlaybackMoments(scene.clip, scene.playback);
  std::vector<double> seconds;
  for (const KeyMark& key : scene.keys) {
    const auto shown = std::find_if(moments.begin(), moments.end(), [&](const Moment& moment) {
      return moment.frame == key.frame;
    });
    seconds.push_back(shown == moments.end() ? 0 : shown->seconds);
  }
  return seconds;
}

PointsX3 WithYUp(const PointsX3& points, bool z_up) {
  if (!z_up) return points;
  PointsX3 turned(points.rows(), 3);
  turned.col(0) = points.col(0);
  turned.col(1) = points.col(2);
  turned.col(2) = -points.col(1);
  return turned;
}

std::string FirstTextureFile(const Scene& scene) {
  const std::vector<std::string>& of_frames = scene.frame_texture_names;
  return of_frames.empty() ? scene.textures[0].FileName(0) : of_frames[0];
}

double SceneDiagonal(const Scene& scene) { return BoundingDiagonal(scene.frames[0].points); }

}  // namespace keypose::exporting
