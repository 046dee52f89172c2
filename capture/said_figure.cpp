#include "capture/said_figure.h"

#include <cstddef>

#include "capture/segmentation/region_cut.h"
#include "core/values/figure_strokes.h"

namespace keypose::capture {
namespace {

/// The stroke's pixels in the working image.
std::vector<Eigen::Vector2i> InSmall(const FigureStroke& stroke, const PhotographImport& import,
                                     std::size_t i) {
  const Photograph& photograph = import.photographs[i];
  const Size size = WrittenSize(import, i);
  const Image8& small = import.small[i];
  const double scale = static_cast<double>(small.width) / size.width;
  std::vector<Eigen::Vector2d> points;
  for (const Eigen::Vector2d& p : stroke.points)
    points.push_back(
        scale * InCaptured(p, {photograph.width, photograph.height}, {size.width, size.height}));
  return PixelsAlong(points, {small.width, small.height});
}

}  // namespace

std::vector<ViewStrokes> StrokesIn(StageContext& stage, const PhotographImport& import,
                                   const std::string& figure) {
  std::vector<ViewStrokes> strokes(import.photographs.size());
  std::vector<std::string> names;
  for (const Photograph& photograph : import.photographs) names.push_back(photograph.name);
  for (const FigureStroke& stroke : ParseFigureStrokes(figure)) {
    if (IndexOfPicture(stroke, import.left_out) >= 0) continue;
    const int image = IndexOfPicture(stroke, names);
    const auto i = static_cast<std::size_t>(image < 0 ? 0 : image);
    if (image < 0 || !import.user_masks[i].empty()) {
      stage.Warn("what was said of the figure in " + stroke.picture + " is not used: " +
                 (image < 0 ? "there is no such photograph" : "it has a mask of your own"));
      continue;
    }
    const std::vector<Eigen::Vector2i> pixels = InSmall(stroke, import, i);
    auto& of = stroke.figure ? strokes[i].figure : strokes[i].other;
    of.insert(of.end(), pixels.begin(), pixels.end());
  }
  return strokes;
}

Image8 SaidMask(StageContext& stage, const std::string& name, const Image8& small,
                const Image8& regions, const ViewStrokes& strokes) {
  const Image8 mask = MaskOfStrokes(small, regions, strokes);
  if (!strokes.figure.empty()) return mask;
  if (!mask.empty()) return BestRegion(mask);
  stage.Warn("in " + name +
             " what was said not to be the figure is all that was found, and stays: say also, by a "
             "click or a line, what the figure is");
  return BestRegion(regions);
}

}  // namespace keypose::capture
