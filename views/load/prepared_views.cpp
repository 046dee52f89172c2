#include "views/load/prepared_views.h"

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "core/values/memory.h"
#include "core/values/size_of.h"

namespace keypose {
namespace {

// The index in the images folder for each view of the model.
std::vector<int> MatchToImages(const std::string& stage_name, const Scene& scene,
                               const ImageSet& set) {
  std::vector<int> index;
  std::vector<std::string> missing, without_mask;
  for (const View& view : scene.views) {
    index.push_back(set.Find(view.name));
    if (index.back() < 0) {
      missing.push_back(view.name);
    } else if (set.images[index.back()].mask.empty()) {
      without_mask.push_back(view.name);
    }
  }
  if (scene.views.empty())
    throw InputError(stage_name + ": the model has no images; run sfm again");
  if (!missing.empty())
    throw InputError(stage_name + ": the model names images that are not in " +
                     set.folder.string() + ": " + NameList(missing) +
                     "; pass the images that the model was made from");
  if (!without_mask.empty())
    throw InputError(stage_name + ": images without a mask: " + NameList(without_mask) +
                     "; run capture again");
  return index;
}

/// Each picture has its own, so that those of the smaller of two cameras keep their detail.
double ScaleFor(const Camera& camera, int max_size) {
  const int longer = std::max({1, camera.width, camera.height});
  return std::min(1.0, static_cast<double>(max_size) / longer);
}

}  // namespace

std::vector<PreparedView> LoadPreparedViews(StageContext& stage, const std::string& stage_name,
                                            const Scene& scene, int max_size, int levels,
                                            int fewest) {
  const ImageSet set = ReadImageSet(stage.Input("images"));
  const std::vector<int> image_of = MatchToImages(stage_name, scene, set);
  std::vector<View> reduced = scene.views;
  for (View& view : reduced) view.camera = view.camera.Scaled(ScaleFor(view.camera, max_size));
  constexpr double kBytesAPixel = 5;  // measured in refine, which takes the least
  RequireMemoryForViews(stage_name, reduced, 1, kBytesAPixel);
  std::vector<PreparedView> views(scene.views.size());
  ParallelFor(std::ssize(views), [&](std::int64_t i) {
    if (!set.images[image_of[i]].trusted) return;
    const Image8 image = ReadImage(set.ImagePath(image_of[i]), 3),
                 mask = ReadImage(set.MaskPath(image_of[i]), 1);
    views[i] = PrepareView(scene.views[i], static_cast<int>(i), image, mask,
                           ScaleFor(scene.views[i].camera, max_size), levels);
  });
  std::vector<std::string> empty, doubted;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const CapturedImage& image = set.images[image_of[i]];
    if (!image.trusted)
      doubted.push_back(image.name);
    else if (views[i].masked_pixels == 0)
      empty.push_back(image.name);
  }
  std::erase_if(views, [](const PreparedView& view) { return view.masked_pixels == 0; });
  if (!empty.empty())
    stage.Note(stage_name +
               ": left out, because the mask is empty or the image too small: " + NameList(empty));
  if (!doubted.empty())
    stage.Note(stage_name +
               ": left out, because they contradict the other photographs: " + NameList(doubted));
  stage.ReportJson("views_distrusted", nlohmann::json(doubted).dump());
  if (SizeOf(views) < fewest)
    throw InputError(stage_name + ": only " + std::to_string(views.size()) + " of " +
                     std::to_string(scene.views.size()) +
                     " images have a mask that is not empty (empty: " + NameList(empty) +
                     ") and agree with the others (contradicting: " + NameList(doubted) +
                     "); check the masks of capture");
  return views;
}

}  // namespace keypose
