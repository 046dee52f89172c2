#include "capture/masks_room.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "capture/agreement/space_queries.h"
#include "capture/room/first_masks.h"
#include "capture/room/room_evidence.h"
#include "capture/salience/salience_network.h"
#include "core/errors.h"
#include "core/figure_strokes.h"
#include "core/size_of.h"

namespace keypose::capture {
namespace {

constexpr double kAgree = 0.9;     // of masks in space: above it they need no second opinion
constexpr double kHardly = 0.8;    // below it they are doubtful in the end
constexpr double kNotAtAll = 0.6;  // below it there is no figure that they agree on

std::string Advice(const std::string& example) {
  return "say what the figure is by one click: keypose figure --pose POSE --at " + example +
         ":X,Y (a pixel of the figure in that photograph), or on the studio's page Poses";
}

/// The middle of the points in most masks; the origin where there are none.
Eigen::Vector3d MiddleOf(const FigureSet& figures, const std::vector<Image8>& masks) {
  std::vector<double> at[3];
  for (const SparsePoint& point : figures.points) {
    std::size_t in = 0;
    for (const int v : point.views) {
      const auto view = static_cast<std::size_t>(v);
      const Eigen::Vector2d p = figures.views[view].Project(point.position);
      const int x = static_cast<int>(std::floor(p.x())), y = static_cast<int>(std::floor(p.y()));
      const Image8& mask = masks[view];
      in += x >= 0 && y >= 0 && x < mask.width && y<mask.height&& * mask.at(x, y)> 127;
    }
    if (2 * in <= point.views.size()) continue;
    for (int k = 0; k < 3; ++k) at[k].push_back(point.position[k]);
  }
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    if (at[k].empty()) continue;
    const auto half = at[k].begin() + static_cast<std::ptrdiff_t>(at[k].size() / 2);
    std::nth_element(at[k].begin(), half, at[k].end());
    middle[k] = *half;
  }
  return middle;
}

/// The strokes of each view, at working size; warns of strokes in photographs that are not there.
std::vector<ViewStrokes> StrokesOf(StageContext& stage, const FigureSet& figures) {
  std::vector<ViewStrokes> strokes(figures.views.size());
  std::vector<std::string> names;
  for (const CapturedImage& image : figures.set.images) names.push_back(image.name);
  for (const FigureStroke& stroke : ParseFigureStrokes(figures.strokes)) {
    const int image = IndexOfPicture(stroke, names);
    const auto view = std::find(figures.index.begin(), figures.index.end(),
                                static_cast<std::size_t>(std::max(0, image)));
    if (image < 0 || view == figures.index.end()) {
      stage.Warn("what was said of the figure in " + stroke.picture + " is not used: " +
                 (image < 0 ? "there is no such photograph" : "it has no camera"));
      continue;
    }
    const auto v = static_cast<std::size_t>(view - figures.index.begin());
    const CapturedImage& captured = figures.set.images[static_cast<std::size_t>(image)];
    const PictureSize written{captured.width, captured.height},
        photograph = captured.photograph_width > 0
                         ? PictureSize{captured.photograph_width, captured.photograph_height}
                         : written;
    const double scale = static_cast<double>(figures.images[v].width) / captured.width;
    std::vector<Eigen::Vector2d> points;
    for (const Eigen::Vector2d& p : stroke.points)
      points.push_back(scale * InCaptured(p, photograph, written));
    const auto pixels = PixelsAlong(points, {figures.images[v].width, figures.images[v].height});
    auto& of = stroke.figure ? strokes[v].figure : strokes[v].other;
    of.insert(of.end(), pixels.begin(), pixels.end());
  }
  return strokes;
}

double Agreement(const FigureSet& figures, const std::vector<Image8>& masks,
                 const SpaceOptions& space) {
  try {
    const auto agreement =
        AgreementInSpace(masks, ContradictionsByOthers(figures.views, masks, space));
    double sum = 0;
    for (const double a : agreement) sum += a / static_cast<double>(agreement.size());
    return sum;
  } catch (const InputError&) {
    return 0;
  }
}

nlohmann::json NamesOf(const FigureSet& figures, const std::vector<int>& views) {
  nlohmann::json names = nlohmann::json::array();
  for (const int v : views)
    names.push_back(figures.set.images[figures.index[static_cast<std::size_t>(v)]].name);
  return names;
}

/// Asks for first masks, and replaces those that no person made.
/// @return whether they could be made
bool Replace(StageContext& stage, const FigureSet& figures, const SpaceOptions& space,
             const std::vector<ViewStrokes>& strokes, std::vector<Image8>& masks) {
  std::unique_ptr<SalienceNetwork> network;
  if (const auto file = FindSalienceNetwork()) network = SalienceNetwork::Open(*file);
  Salience salience;
  if (network)
    salience = [&network](const Image8& rgb, bool mirrored) {
      return network->Of(rgb, mirrored ? SalienceFit::kMirrored : SalienceFit::kStretched);
    };
  else
    stage.Note(std::string("masks: ") + kNoSalience +
               ", so what is the figure is told by strokes, colours and views alone");
  SubProgress progress(stage.progress(), 0.1, 0.25);
  FirstMasks first =
      MakeFirstMasks(figures.images, figures.views, MiddleOf(figures, masks), strokes,
                     figures.boards, salience, figures.masking, space, {}, &progress);
  stage.ReportJson("figure_asked", NamesOf(figures, first.asked).dump());
  stage.ReportJson("figure_told", NamesOf(figures, first.told).dump());
  if (first.unclear) return false;
  for (std::size_t v = 0; v < masks.size(); ++v)
    if (!figures.set.images[figures.index[v]].mask_given) masks[v] = std::move(first.masks[v]);
  return true;
}

}  // namespace

bool FindFigure(StageContext& stage, const FigureSet& figures, SpaceOptions& space,
                std::vector<Image8>& masks) {
  const RoomEvidence room = LookAround({figures.views, figures.points}, masks);
  const bool said = !figures.strokes.empty();
  const bool shows_room = room.in_room || room.floor_in_masks;
  stage.Report("in_room", shows_room);
  stage.Report("points_around", room.around);
  if (!shows_room && !said) return false;
  if (room.floor && shows_room) space.floor = 0;
  stage.Report("floor_in_masks", room.on_floor);
  const double agreement = Agreement(figures, masks, space);
  if (!said && !room.floor_in_masks && agreement >= kAgree) {
    stage.Report("figure_by", "colours and views");
    return true;
  }
  ReportProgress(stage.progress(), 0.1, "what is the figure");
  const bool replaced = Replace(stage, figures, space, StrokesOf(stage, figures), masks);
  stage.Report("figure_by", replaced ? said ? "strokes" : "the network" : "colours and views");
  if (replaced || agreement >= kNotAtAll) return true;
  stage.Report("figure_unclear", true);
  throw InputError("masks: it cannot be told what the figure is: in " +
                   std::to_string(SizeOf(figures.views)) +
                   " photographs the masks hold different things; " +
                   Advice(figures.set.images[figures.index[0]].name));
}

void RequireClearFigure(StageContext& stage, double agreement, const std::string& example) {
  const bool unclear = agreement < kHardly;
  stage.Report("figure_unclear", unclear);
  if (agreement < kNotAtAll)
    throw InputError("masks: it cannot be told what the figure is: the masks agree in space by " +
                     std::to_string(static_cast<int>(std::lround(100 * agreement))) + " % only; " +
                     Advice(example));
  if (unclear)
    stage.Warn("it is doubtful what the figure is: the masks agree in space by " +
               std::to_string(static_cast<int>(std::lround(100 * agreement))) +
               " % only; look at masks_agreed.jpg, and " + Advice(example));
}

}  // namespace keypose::capture
