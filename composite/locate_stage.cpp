// keypose-locate: the camera of a filmed shot, and the character's place in its frames.
#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "composite/locate_input.h"
#include "composite/locate_output.h"
#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/stage/stage.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::composite {
namespace {

constexpr double kRival = 1.25;       // a place seen from elsewhere that fits nearly as well
constexpr double kGoodContour = 1.5;  // px

StageSpec Spec() {
  StageSpec spec;
  spec.name = "locate";
  spec.version = "11";
  spec.summary = "Finds the camera of a filmed shot, and the character's place in its frames.";
  spec.title = "Camera of the shot";
  spec.inputs = {
      {"frames", "folder", "the animation's meshes (frame_0000.ply, ...)", "", true, false},
      {"mesh", "file", "instead: the mesh of each pose that the film shows", "", true, true},
      {"textures", "path", "the texture, or a folder whose first picture it is", "", true, false},
      {"plate", "path", "the filmed picture, a folder of numbered ones, or a video (.mp4, .mov)",
       "", false, false},
      {"matte", "path",
       "255 where the character is, as grey or as alpha; numbered as the pictures are, or a video",
       "", true, false},
      {"background", "path",
       "the set without the character (a clean plate); of a moving camera one for each picture", "",
       true, false},
      {"clicks", "file", "pairs of a pixel and a place on the mesh (.json)", "", true, false},
      {"ocio_config", "file", "OpenColorIO configuration (.ocio) of OpenEXR or DPX pictures", "",
       true, false}};
  spec.outputs = {
      {"shot", "file", "the camera and the character's places", "shot.json", false, false},
      {"picture", "file", "outlines over the frames: what mesh and filmed sculpt differ by",
       "located.png", true, false}};
  spec.memory_gib = 3;
  spec.common = {"shows", "poses", "focal_35mm", "camera"};
  return spec;
}

void RequireCharacter(const LocateInput& input, const LocatedShot& located, double min_iou) {
  for (int i = 0; i < SizeOf(located.frames); ++i) {
    const LocatedFrame& frame = located.frames[i];
    if (frame.iou >= min_iou || frame.matte.empty() || IsBetween(input, i)) continue;
    throw InputError(fmt::format(
        "locate: no character found in {}: the best place of the mesh overlaps with the matte by "
        "{:.2f} only (IoU; --min_iou is {:.2f}); check that the picture shows this character in "
        "this pose, or pass --clicks{}",
        input.shot.frames[i].name, frame.iou, min_iou,
        input.shot.still && i > 0
            ? "; and if the camera moved in this shot, say so by --camera moving (in a project "
              "`options: {locate: {camera: moving}}`)"
            : ""));
  }
}

/// Between keys of a moving camera a frame may be missing: the animation passes beside the film.
void LeaveOut(StageContext& stage, const LocateInput& input, double min_iou, LocatedShot* located) {
  for (int i = 0; i < SizeOf(located->frames); ++i) {
    LocatedFrame& frame = located->frames[i];
    if (!IsBetween(input, i) || frame.iou >= min_iou || frame.matte.empty()) continue;
    frame.left_out = true;
    stage.Warn(fmt::format(
        "locate: {} is left out: the animation overlaps with what was filmed by {:.2f} only (IoU); "
        "the camera goes there on a smooth way between its neighbours",
        input.shot.frames[i].name, frame.iou));
  }
}

void WarnOf(StageContext& stage, const LocateInput& input, const LocatedShot& located) {
  if (located.focal == "kept")
    stage.Warn(fmt::format(
        "locate: the pictures do not show the focal length (it is uncertain by {:.0f} %), so it is "
        "kept at {:.0f} mm (35 mm equivalent); give the lens's by --focal_35mm",
        100 * located.profile_deviation,
        36 * located.camera.fx / std::max(located.camera.width, located.camera.height)));
  for (int i = 0; i < SizeOf(located.frames); ++i) {
    const LocatedFrame& frame = located.frames[i];
    if (frame.rival_ratio > 0 && frame.rival_ratio < kRival)
      stage.Warn(fmt::format(
          "locate: {}: the outline fits nearly as well from another side ({:.2f} of the distance); "
          "look at the picture of the result, and pass --clicks if it is wrong",
          input.shot.frames[i].name, frame.rival_ratio));
  }
}

std::string WorstOf(const LocatedShot& located, const LocateInput& input, double* contour) {
  int worst = 0;
  for (int i = 1; i < SizeOf(located.frames); ++i)
    if (located.frames[i].contour_px > located.frames[worst].contour_px) worst = i;
  *contour = located.frames[worst].contour_px / input.scale;
  return input.shot.frames[worst].name;
}

void Judge(StageContext& stage, const LocateInput& input, const LocatedShot& located) {
  double contour = 0;
  const std::string worst = WorstOf(located, input, &contour);
  if (contour <= kGoodContour)
    stage.Verdict("shot", "good",
                  fmt::format("outlines agree to {:.2f} px in every frame", contour));
  else
    stage.Verdict(
        "shot", "look",
        fmt::format("outlines of {} differ by {:.1f} px: compare them in the picture; the "
                    "filmed sculpt may have changed since it was scanned, or the matte "
                    "may be wrong",
                    worst, contour));
}

void Run(StageContext& stage, const LocateStageOptions& options) {
  LocateInput input;
  ReadLocateInput(stage, options, input);
  LocatedShot located = LocateShot(input.shot, stage.progress());
  RequireCharacter(input, located, options.min_iou);
  LeaveOut(stage, input, options.min_iou, &located);
  ReportShot(stage, input, located);
  WarnOf(stage, input, located);
  Judge(stage, input, located);
  WriteFile(stage.Output("shot"), ShotText(ShotOf(input, located)));
  if (const auto path = stage.Output("picture"); !path.empty())
    WriteImage(path, DriftPicture(input, located));
}

}  // namespace
}  // namespace keypose::composite

int main(int argc, char** argv) {
  return keypose::RunStage<keypose::composite::LocateStageOptions>(
      argc, argv, keypose::composite::Spec(), keypose::composite::Run);
}
