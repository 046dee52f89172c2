#include "export/gltf/gltf.h"

#include <algorithm>
#include <iterator>

#include "core/values/size_of.h"
#include "export/gltf/glb_builder.h"

namespace keypose::exporting {
namespace {

/// All pictures but the first, ascending.
std::vector<int> TargetPictures(const Clip& clip) {
  std::vector<int> targets;
  for (int i = 1; i < clip.frame_count(); ++i)
    if (clip.picture[i] == i) targets.push_back(i);
  return targets;
}

/// At a keyframe, the weight of its picture's target is 1 and all others are 0. The first picture
/// is the mesh itself.
GlbWeights WeightsOverTime(const Clip& clip, const PlaybackOptions& playback,
                           const std::vector<int>& targets) {
  GlbWeights track;
  if (targets.empty()) return track;
  const auto moments = PlaybackMoments(clip, playback);
  std::vector<Keyframe> keyframes = StepKeyframes(moments, clip);
  track.steps = !keyframes.empty();
  if (!track.steps) keyframes = LinearKeyframes(moments, clip, playback.fps);
  track.weights = FloatRows::Zero(std::ssize(keyframes), std::ssize(targets));
  for (int i = 0; i < SizeOf(keyframes); ++i) {
    track.seconds.push_back(keyframes[i].seconds);
    const int picture = clip.picture[keyframes[i].frame];
    const auto target = std::lower_bound(targets.begin(), targets.end(), picture);
    if (picture > 0) track.weights(i, target - targets.begin()) = 1;
  }
  return track;
}

}  // namespace

std::string MakeGlb(const AnimatedMesh& mesh, const Clip& clip,
                    const std::vector<std::string>& frame_names, const GlbTextures& textures,
                    const GlbOptions& options) {
  const auto shape = [&](int frame) {
    return GlbShape{GltfRows(mesh.points[frame], options.z_up),
                    GltfRows(mesh.normals[frame], options.z_up)};
  };
  const std::vector<int> targets = TargetPictures(clip);
  const GlbShape base = shape(0);
  GlbBuilder builder(mesh, options.name);
  builder.Base(base);
  for (const int i : targets) {
    GlbShape difference = shape(i);
    difference.positions -= base.positions;
    difference.normals -= base.normals;
    builder.Target(frame_names[i], difference);
  }
  const GlbWeights track = WeightsOverTime(clip, options.playback, targets);
  return builder.Finish(std::vector<double>(targets.size(), 0.0), textures, track);
}

double GlbError(const AnimatedMesh& mesh) {
  using FloatsX3 = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;
  const FloatsX3 base = mesh.points[0].cast<float>();
  double worst = 0;
  for (const PointsX3& points : mesh.points) {
    const FloatsX3 target = points.cast<float>() - base;
    const FloatsX3 shown = base + target;
    worst = std::max(worst, (shown.cast<double>() - points).rowwise().norm().maxCoeff());
  }
  return worst;
}

}  // namespace keypose::exporting
