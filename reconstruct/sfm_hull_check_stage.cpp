#include "reconstruct/sfm_hull_check_stage.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/io/image_io.h"
#include "core/io/image_set.h"
#include "core/parallel.h"
#include "reconstruct/silhouettes.h"
#include "reconstruct/visual_hull.h"

namespace keypose::reconstruct {

std::vector<DenseView> MaskViews(const ImageSet& set, const Scene& scene) {
  constexpr double kSide_px = 500;
  std::vector<DenseView> views(scene.views.size());
  ParallelFor(static_cast<std::int64_t>(views.size()), [&](std::int64_t v) {
    View view = scene.views[static_cast<std::size_t>(v)];
    const int i = set.Find(view.name);
    if (i < 0 || set.images[static_cast<std::size_t>(i)].mask.empty()) return;
    view.camera = view.camera.Scaled(std::min(1.0, kSide_px / std::max(view.camera.width, view.camera.height)));
    const Image8 mask = Resized(ReadImage(set.MaskPath(i), 1), view.camera.width, view.camera.height);
    // The hull asks for no colour.
    const Image8 grey(view.camera.width, view.camera.height, 3, 128);
    views[static_cast<std::size_t>(v)] = PrepareDenseView(view, static_cast<int>(v), grey, mask, 1, 1);
  });
  std::erase_if(views, [](const DenseView& view) { return view.masked_pixels == 0; });
  return views;
}

void ReportHullAgreement(StageContext& stage, const ImageSet& set, const Scene& scene) {
  const std::vector<DenseView> views = MaskViews(set, scene);
  if (views.size() < 3) return;
  VisualHullOptions options;
  options.resolution = 96;
  HullCheck check;
  try {
    check = CheckAgainstHull(views, CarveVisualHull(views, options), Silhouettes(views, options.outside_votes));
  } catch (const InputError& error) {
    stage.Warn(std::string("the masks and the cameras do not fit: ") + error.what());
    stage.Report("hull_iou_mean", 0);
    return;
  }
  stage.Report("hull_iou_mean", check.mean);
  stage.Report("hull_iou_least", *std::min_element(check.iou.begin(), check.iou.end()));
  stage.ReportJson("views_disagreeing", nlohmann::json(check.disagreeing).dump());
  if (check.disagreeing.empty()) return;
  std::string names;
  for (const std::string& name : check.disagreeing) names += (names.empty() ? "" : ", ") + name;
  stage.Warn("the outlines of these photographs do not fit the other ones: " + names +
             "; look at their masks (contact_sheet.jpg), and whether they were cropped, turned, or shot with another zoom");
}

}  // namespace keypose::reconstruct
