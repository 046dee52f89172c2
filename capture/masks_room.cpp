#include "capture/masks_room.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "capture/pictures/contact_sheet.h"
#include "capture/room/coarse_depths.h"
#include "capture/room/first_masks.h"
#include "capture/room/floor_picture.h"
#include "capture/room/free_standing.h"
#include "capture/room/hidden_parts.h"
#include "capture/room/room_evidence.h"
#include "capture/room/standing_figure.h"
#include "capture/room/told_by_depths.h"
#include "capture/salience/salience_network.h"
#include "core/io/pictures/image_io.h"
#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/pictures/mask_overlap.h"
#include "core/stage/failure_picture.h"
#include "core/values/errors.h"
#include "core/values/figure_strokes.h"
#include "core/values/percent.h"
#include "core/values/size_of.h"

namespace keypose::capture {
namespace {

constexpr double kAgree = 0.9;   // of the masks that others leave: above it they agree
constexpr double kSame = 0.85;   // of the masks and what was told: above it both mean one thing
constexpr double kHardly = 0.8;  // below it they are doubtful in the end
constexpr std::size_t kFewViews = 16;  // photographs
constexpr double kSeenByMost = 0.75;   // of few photographs
constexpr double kShownByMost = 0.7;   // of the photographs have depths of the figure
constexpr double kMostBeyond = 0.6;    // of the photographs
constexpr double kUpright = 0.99;      // cosine: a plane is level
constexpr double kNotAtAll = 0.6;      // below it there is no figure that they agree on

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
  for (int k = 0; k < 3; ++k) middle[k] = UpperMedian(std::move(at[k]));
  return middle;
}

/// Quarter turns that put each photograph upright: by the floor where there is one; else those that
/// capture turned are turned back.
std::vector<int> TurnsOf(const FigureSet& figures, const Eigen::Vector3d& middle, bool floor) {
  std::vector<int> turns;
  for (std::size_t v = 0; v < figures.views.size(); ++v) {
    const CapturedImage& image = figures.set.images[figures.index[v]];
    const bool portrait = image.photograph_width < image.photograph_height;
    const bool turned = image.photograph_width > 0 && portrait != (image.width < image.height);
    const int back = turned ? 3 : 0;
    turns.push_back(floor ? TurnsToUpright(figures.views[v], middle) : back);
  }
  return turns;
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

double Mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value / static_cast<double>(values.size());
  return sum;
}

nlohmann::json NamesOf(const FigureSet& figures, const std::vector<int>& views) {
  nlohmann::json names = nlohmann::json::array();
  for (const int v : views)
    names.push_back(figures.set.images[figures.index[static_cast<std::size_t>(v)]].name);
  return names;
}

ToldFigure Ask(StageContext& stage, const FigureSet& figures,
               const std::vector<ViewStrokes>& strokes, const SpaceOptions& space,
               const std::vector<Image8>& masks) {
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
  SubProgress progress(stage.progress(), 0.05, 0.15);
  const Eigen::Vector3d middle = MiddleOf(figures, masks);
  ToldFigure told = AskAboutFigure(figures.images, figures.views, middle,
                                   TurnsOf(figures, middle, std::isfinite(space.floor)), strokes,
                                   salience, space, {}, &progress);
  stage.ReportJson("figure_asked", NamesOf(figures, told.asked).dump());
  stage.ReportJson("figure_told", NamesOf(figures, told.fitting).dump());
  return told;
}

/// Writes a sheet of what was taken for the figure, for a person who reads why it is refused.
/// @return a sentence with its path
std::string Shown(StageContext& stage, const FigureSet& figures, const std::vector<Image8>& masks) {
  constexpr int kCellWidth = 240;
  std::vector<Image8> cells;
  for (std::size_t v = 0; v < masks.size(); ++v)
    cells.push_back(ContactCell(figures.images[v], masks[v],
                                figures.set.images[figures.index[v]].name, kCellWidth));
  const std::filesystem::path sheet = FailurePicture(stage, "masked");
  WriteImage(sheet, ContactSheet(cells));
  return "; what was taken for the figure: " + sheet.string();
}

/// The median overlap of the masks with what was told.
double Overlap(const ToldFigure& told, const std::vector<Image8>& masks) {
  std::vector<double> overlaps;
  for (const int v : told.fitting)
    overlaps.push_back(
        MaskIoU(told.views[static_cast<std::size_t>(v)].mask, masks[static_cast<std::size_t>(v)]));
  return UpperMedian(std::move(overlaps));
}

/// What is known before it is said what the figure is.
struct Around {
  bool shows_room = false, floor_in_masks = false;
};

/// Looks at what is around the figure, and sets the floor, below which nothing of it is.
Around LookAt(StageContext& stage, const FigureSet& figures, SpaceOptions& space,
              const std::vector<Image8>& masks) {
  const RoomEvidence room = LookAround({figures.views, figures.points}, masks);
  const bool shows_room = room.in_room || room.floor_in_masks;
  stage.Report("in_room", shows_room);
  stage.Report("points_around", room.around);
  if (!shows_room && figures.strokes.empty()) return {};
  if (room.floor && shows_room) space.floor = 0;
  stage.Report("floor_in_masks", room.on_floor);
  // Few photographs, often of one side, leave much space that hardly any of them shows: it is not
  // the figure's.
  if (figures.views.size() < kFewViews) space.least_seen = kSeenByMost;
  return {shows_room, room.floor_in_masks};
}

/// Carries what was told to all photographs; masks that a person made stay.
void TakeTold(const FigureSet& figures, const ToldFigure& told, const SpaceOptions& space,
              std::vector<Image8>& masks) {
  std::vector<Image8> carried =
      CarryToAll(figures.images, figures.views, told, figures.known, figures.masking, space);
  for (std::size_t v = 0; v < masks.size(); ++v)
    if (!figures.set.images[figures.index[v]].mask_given) masks[v] = std::move(carried[v]);
}

/// What depths show of the figure.
struct ShownByDepths {
  ToldFigure near;  ///< what is far from any depth of the figure is not the figure
  ToldFigure open;  ///< or is not known
  double floor = -std::numeric_limits<double>::infinity();  ///< z
  std::vector<HiddenPart> hidden;                           ///< by view
};

/// @return nothing where no plane was found, nothing stands on it, or few photographs show it
std::optional<ShownByDepths> LookAtDepths(StageContext& stage, const FigureSet& figures,
                                          const std::vector<Image8>& masks, const ToldFigure& told,
                                          const std::vector<ViewStrokes>& strokes) {
  const Eigen::Vector3d middle = MiddleOf(figures, masks);
  SubProgress progress(stage.progress(), 0.15, 0.25);
  const CoarseDepths depths =
      FindCoarseDepths(figures.images, {figures.views, figures.points}, middle, {}, &progress);
  Opinions opinions{{}, strokes};
  for (const ToldView& view : told.views) opinions.masks.push_back(view.mask);
  const auto standing = FindStandingFigure(depths, figures.views, middle, opinions);
  stage.Report("figure_stands", standing.has_value() && !standing->on_wall);
  if (!standing) return std::nullopt;
  if (standing->on_wall && !figures.strokes.empty()) return std::nullopt;
  if (standing->on_wall)
    throw InputError(
        "masks: the figure does not stand free: what is behind it is a wall that it is part of, or "
        "hangs on, as a relief; photograph a figure that stands free, from all sides, or " +
        Advice(figures.set.images[figures.index[0]].name) + Shown(stage, figures, masks));
  const FloorPicture picture(figures.images, figures.views, depths, *standing);
  std::vector<Image8> floor(figures.images.size());
  ParallelFor(std::ssize(floor), [&](std::int64_t k) {
    const auto v = static_cast<std::size_t>(k);
    floor[v] = LikeFloor(figures.images[v], picture.SeenBy(figures.views[v]));
  });
  ShownByDepths shown;
  shown.near = TellByDepths(figures.images, figures.views, depths, *standing, floor);
  AddStrokes(strokes, shown.near);
  shown.open = TellByDepths(figures.images, figures.views, depths, *standing, floor,
                            {.near = std::numeric_limits<double>::infinity()});
  shown.hidden = HiddenParts(figures.views, *standing);
  if (standing->support.up.z() > kUpright) shown.floor = standing->support.height;
  if (static_cast<double>(shown.near.fitting.size()) <
      kShownByMost * static_cast<double>(figures.views.size()))
    return std::nullopt;
  return shown;
}

/// Carries to all photographs what depths show of the figure, and the network said.
/// @param said  masks of the network; where a person's strokes chose among depths, nothing
FoundFigure TakeStanding(StageContext& stage, const FigureSet& figures, const ToldFigure& said,
                         const ShownByDepths& shown, SpaceOptions& space,
                         std::vector<Image8>& masks) {
  const ToldFigure both = ToldByBoth(said, shown.open);
  const bool agree = !both.fitting.empty();
  const ToldFigure& told = agree ? both : shown.near;
  const ToldFigure& by_depths = agree ? shown.open : shown.near;
  for (const int view : by_depths.fitting) {
    const auto v = static_cast<std::size_t>(view);
    if (figures.known[v].odds.empty())
      // Windows without texture widen the figure by more than its border: a network knows better.
      figures.known[v] = KnownOdds(by_depths.views[v], agree ? 0 : figures.masking.odds_limit,
                                   figures.masking.odds_limit);
  }
  if (std::isfinite(shown.floor)) space.floor = shown.floor;
  FoundFigure found{true, true, {}};
  for (const HiddenPart& part : shown.hidden) {
    space.hidden.push_back(part.where);
    found.hidden.push_back(part.share);
  }
  TakeTold(figures, told, space, masks);
  // A network's outline would be better; of depths' masks nothing is left for colours to learn.
  space.segmented = !agree;
  const char* by = agree ? "depths and the network" : "depths";
  stage.Report("figure_by", figures.strokes.empty() ? by : "depths and strokes");
  return found;
}

/// Share of the pixels that lie in the mask, or within two pixels of it.
double ShareIn(const Image8& mask, const std::vector<Eigen::Vector2i>& pixels) {
  constexpr int kReach = 2;
  const auto near = [&](const Eigen::Vector2i& at) {
    for (int y = std::max(0, at.y() - kReach); y <= std::min(mask.height - 1, at.y() + kReach); ++y)
      for (int x = std::max(0, at.x() - kReach); x <= std::min(mask.width - 1, at.x() + kReach);
           ++x)
        if (*mask.at(x, y) > 127) return true;
    return false;
  };
  return static_cast<double>(std::count_if(pixels.begin(), pixels.end(), near)) /
         static_cast<double>(pixels.size());
}

/// Warns where the masks are not what a person said.
void WarnOfUnheeded(StageContext& stage, const FigureSet& figures,
                    const std::vector<Image8>& masks) {
  constexpr double kMost = 0.5;
  if (figures.strokes.empty()) return;
  const std::vector<ViewStrokes> strokes = StrokesOf(stage, figures);
  int unheeded = 0;
  for (std::size_t v = 0; v < strokes.size(); ++v) {
    const std::string& photograph = figures.set.images[figures.index[v]].name;
    const bool lost = !strokes[v].figure.empty() && ShareIn(masks[v], strokes[v].figure) < kMost,
               kept = !strokes[v].other.empty() && ShareIn(masks[v], strokes[v].other) > kMost;
    if (lost)
      stage.Warn("what was said to be the figure in " + photograph +
                 " is not in its mask: the other photographs show something else there; look at "
                 "masks_agreed.jpg, and say it in two or three more photographs, or take it back "
                 "(keypose figure --pose POSE --clear)");
    if (kept)
      stage.Warn(
          "what was said not to be the figure in " + photograph +
          " is in its mask: it cannot be told from the figure by what the other photographs "
          "show; look at masks_agreed.jpg, and draw a line over all of it, in two photographs");
    unheeded += lost || kept;
  }
  stage.Report("photographs_unlike_said", unheeded);
}

}  // namespace

FoundFigure FindFigure(StageContext& stage, const FigureSet& figures, SpaceOptions& space,
                       std::vector<Image8>& masks) {
  std::filesystem::remove(FailurePicture(stage, "masked"));
  const bool said = !figures.strokes.empty();
  const Around around = LookAt(stage, figures, space, masks);
  if (!around.shows_room && !said) return {};
  ReportProgress(stage.progress(), 0.05, "what is the figure");
  const std::vector<ViewStrokes> strokes = StrokesOf(stage, figures);
  const ToldFigure told = Ask(stage, figures, strokes, space, masks);
  const std::optional<ShownByDepths> shown = LookAtDepths(stage, figures, masks, told, strokes);
  if (shown) return TakeStanding(stage, figures, said ? ToldFigure{} : told, *shown, space, masks);
  if (told.network_errs && told.fitting.empty())
    throw InputError(
        "masks: the network takes what you said is not the figure for a part of it, so that your "
        "strokes alone tell what it is: mark the figure, and what is not, in three or more "
        "photographs from different sides (keypose figure --pose POSE --at PHOTO:X,Y --not "
        "PHOTO:X,Y-X,Y, or the studio's page Poses); " +
        std::to_string(SizeOf(told.asked)) + " so far");
  const double left = Mean(LeftByOthers(figures.views, masks, space));
  const double overlap = Overlap(told, masks);
  stage.Report("masks_left_by_others", left);
  stage.Report("masks_like_told", overlap);
  const bool same = !said && !around.floor_in_masks && overlap >= kSame && left >= kAgree;
  if (!told.fitting.empty() && !same) {
    TakeTold(figures, told, space, masks);
    stage.Report("figure_by", said ? "strokes" : "the network");
    return {true, false};
  }
  stage.Report("figure_by", same ? "colours, views and the network" : "colours and views");
  if (same || left >= kAgree) return {true, false};
  stage.Report("figure_unclear", true);
  throw InputError(
      "masks: it cannot be told what the figure is: in " + std::to_string(SizeOf(figures.views)) +
      " photographs the masks hold different things; " +
      Advice(figures.set.images[figures.index[0]].name) + Shown(stage, figures, masks));
}

void RequireClearFigure(StageContext& stage, const FigureSet& figures, const SpaceOptions& space,
                        const FoundFigure& found, const std::vector<Image8>& masks) {
  const double left = Mean(LeftByOthers(figures.views, masks, space));
  const std::string percent = PercentHalfUp(left);
  WarnOfUnheeded(stage, figures, masks);
  const std::string advice = Advice(figures.set.images[figures.index[0]].name);
  stage.Report("figure_unclear", left < kHardly);
  const Attachment attachment =
      FindAttachment({figures.views, figures.points}, masks, std::isfinite(space.floor));
  stage.Report("goes_on_beside", attachment.share);
  if (attachment.attached && figures.strokes.empty() && !found.stands)
    throw InputError(
        "masks: the figure does not stand free: " + PercentHalfUp(attachment.share) +
        " of what is seen just beside its outlines is as near as the figure itself, as around a "
        "relief on a wall or a carving on a trunk, which have no shape of their own; photograph a "
        "figure that stands free, or " +
        advice + Shown(stage, figures, masks));
  const double beyond = BeyondThePictures(masks);
  stage.Report("goes_on_beyond", beyond);
  if (beyond > kMostBeyond && figures.strokes.empty())
    throw InputError(
        "masks: the figure does not stand free: in " + PercentHalfUp(beyond) +
        " of the photographs what could be the figure goes on beyond three sides of the picture, "
        "as a trunk in a wood does, or a room; photograph a figure that stands free, or " +
        advice + Shown(stage, figures, masks));
  if (left < kNotAtAll)
    throw InputError("masks: it cannot be told what the figure is: of each mask only " + percent +
                     " lies where the other photographs have it too; " + advice +
                     Shown(stage, figures, masks));
  if (left < kHardly)
    stage.Warn("it is doubtful what the figure is: of each mask only " + percent +
               " lies where the other photographs have it too; look at masks_agreed.jpg, and " +
               advice);
}

}  // namespace keypose::capture
