#include "export/fbx/fbx_animation.h"

#include <bit>

#include "core/values/size_of.h"
#include "export/fbx/fbx_mesh.h"

namespace keypose::exporting {
namespace {

constexpr std::int32_t kLinear = 4;
constexpr float kFullPercent = 100;

struct CurveKeys {
  std::vector<std::int64_t> ticks;
  std::vector<float> percents;
};

/// Per keyframe, the picture that it shows.
std::vector<int> Pictures(const std::vector<Keyframe>& keyframes, const Clip& clip) {
  std::vector<int> pictures;
  for (const Keyframe& keyframe : keyframes) pictures.push_back(clip.picture[keyframe.frame]);
  return pictures;
}

/// Keys at the shape's own keyframes, at their neighbours, and at both ends, which tell some
/// players how long the animation is.
CurveKeys CurveOf(int frame, const std::vector<Keyframe>& keyframes,
                  const std::vector<int>& pictures) {
  CurveKeys curve;
  const int last = SizeOf(keyframes) - 1;
  for (int k = 0; k <= last; ++k) {
    const bool shows = pictures[k] == frame;
    const bool beside =
        (k > 0 && pictures[k - 1] == frame) || (k < last && pictures[k + 1] == frame);
    if (!shows && !beside && k > 0 && k < last) continue;
    curve.ticks.push_back(FbxTicks(keyframes[k].seconds));
    curve.percents.push_back(shows ? kFullPercent : 0);
  }
  return curve;
}

FbxRecord CurveRecord(const CurveKeys& curve, std::int64_t id) {
  // Slopes of 0, and tangents of a third of the way each; linear keys use neither, but readers
  // expect four numbers.
  const float thirds = std::bit_cast<float>((3333 << 16) + 3333);
  return {"AnimationCurve",
          {id, FbxName("", "AnimCurve"), ""},
          {{"Default", {0.0}},
           {"KeyVer", {4009}},
           {"KeyTime", {curve.ticks}},
           {"KeyValueFloat", {curve.percents}},
           {"KeyAttrFlags", {std::vector<std::int32_t>{kLinear}}},
           {"KeyAttrDataFloat", {std::vector<float>{0, 0, thirds, 0}}},
           {"KeyAttrRefCount", {std::vector<std::int32_t>{SizeOf(curve.ticks)}}}}};
}

FbxRecord CurveNode(std::int64_t id) {
  return {"AnimationCurveNode",
          {id, FbxName("DeformPercent", "AnimCurveNode"), ""},
          {FbxProperties({{"d|DeformPercent", "Number", "", "A", 0.0}})}};
}

FbxRecord Stack(const std::string& name, double seconds) {
  const std::int64_t end = FbxTicks(seconds);
  return {"AnimationStack",
          {kFbxStackId, FbxName(name, "AnimStack"), ""},
          {FbxProperties({{"LocalStart", "KTime", "Time", "", FbxTicks(0)},
                          {"LocalStop", "KTime", "Time", "", end},
                          {"ReferenceStart", "KTime", "Time", "", FbxTicks(0)},
                          {"ReferenceStop", "KTime", "Time", "", end}})}};
}

}  // namespace

double FbxSeconds(const Scene& scene) {
  return PlaybackMoments(scene.clip, scene.playback).back().seconds;
}

void AddFbxAnimation(const Scene& scene, const std::vector<int>& frames, FbxObjects& out) {
  if (frames.empty()) return;
  out.objects.push_back(Stack(scene.name, FbxSeconds(scene)));
  out.objects.push_back(
      {"AnimationLayer", {kFbxLayerId, FbxName(scene.name, "AnimLayer"), ""}, {}});
  out.Connect(kFbxLayerId, kFbxStackId);
  const std::vector<Keyframe> keyframes = SceneKeyframes(scene);
  const std::vector<int> pictures = Pictures(keyframes, scene.clip);
  for (int k = 0; k < SizeOf(frames); ++k) {
    const FbxShapeIds ids(k);
    out.objects.push_back(CurveNode(ids.curve_node));
    out.objects.push_back(CurveRecord(CurveOf(frames[k], keyframes, pictures), ids.curve));
    out.Connect(ids.curve_node, kFbxLayerId);
    out.Connect(ids.curve_node, ids.channel, "DeformPercent");
    out.Connect(ids.curve, ids.curve_node, "d|DeformPercent");
  }
}

}  // namespace keypose::exporting
