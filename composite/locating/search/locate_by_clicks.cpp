#include "composite/locating/search/locate_by_clicks.h"

#include "core/pictures/mask_overlap.h"
#include "core/values/size_of.h"

namespace keypose::composite {
namespace {

constexpr int kClicksForFocal = 6;
constexpr double kQuickReach = 20;  // px, of the smallest size

LocatedFrame FrameByClicks(ShotFrames& frames, int i, const Camera& camera, bool focal_is_known) {
  const LocateFrame& frame = frames.input().frames[i];
  const Figure& figure = frames.FigureOf(i).fine;
  LocatedFrame found;
  found.method = "clicks";
  found.at = PlaceByClicks(camera, figure.points, frame.clicks, !focal_is_known);
  found.matte = frame.matte;
  if (frame.matte.empty()) {
    for (const SilhouettePoint& point : FindSilhouette(figure, found.at, 2))
      found.outlines.push_back({point.position, point.pixel, point.normal, 0, point.length_px});
    return found;
  }
  PictureEvidence rough =
      MakeEvidence(frame.picture, frame.matte, frame.matte_deviation_px, frames.roughest_scale());
  SetClicks(rough, frame.clicks);
  found.at = Refined(figure, rough, found.at, {kQuickReach, kFine, 4}, {});
  const Placement scaled = found.at.Scaled(rough.scale);
  const OutlineMatches outlines =
      MatchOutlines(FindSilhouette(figure, scaled, 2), rough.outline, 4 * kReach);
  found.outlines = outlines.matches;
  for (OutlineMatch& match : found.outlines) {
    match.pixel /= rough.scale;
    match.distance_px /= rough.scale;
  }
  found.contour_px = outlines.Mean(kReach) / rough.scale;
  found.iou = MaskIoU(Covered(figure, scaled), rough.matte);
  return found;
}

}  // namespace

LocatedShot LocateByClicks(ShotFrames& frames) {
  const ShotInput& input = frames.input();
  LocatedShot shot;
  for (int i = 0; i < frames.count(); ++i) {
    frames.Tell(static_cast<double>(i) / frames.count(), "clicks of " + input.frames[i].name);
    const bool known = frames.focal_known() || i > 0;
    const Camera& camera = i > 0 ? shot.camera : input.camera;
    shot.frames.push_back(FrameByClicks(frames, i, camera, known));
    shot.camera = shot.frames[0].at.camera;
  }
  const bool solved = SizeOf(input.frames[0].clicks) >= kClicksForFocal;
  shot.focal = solved ? "solved" : "kept";
  if (input.focal_deviation > 0) shot.focal = "exif";
  shot.focal_deviation = frames.focal_known() ? input.focal_deviation : 1;
  if (input.focal_fixed) {
    shot.focal = "given";
    shot.focal_deviation = 0;
  }
  return shot;
}

}  // namespace keypose::composite
