// keypose-masks: makes masks consistent in space, once the cameras are known.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>

#include "capture/agreement/space_masks.h"
#include "capture/board/board_detection.h"
#include "capture/masks_options.h"
#include "capture/masks_room.h"
#include "capture/pictures/contact_sheet.h"
#include "capture/pictures/working_image.h"
#include "capture/salience/salience_network.h"
#include "capture/segmentation/masking.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/io/project/colmap_io.h"
#include "core/numbers/parallel.h"
#include "core/stage/stage.h"
#include "core/values/errors.h"
#include "core/values/memory.h"
#include "core/values/percent.h"

namespace {
namespace fs = std::filesystem;
using namespace keypose;
using namespace keypose::capture;

constexpr int kCellWidth = 240;

/// The photographs that have a camera, at working size.
struct PosedImages {
  std::vector<std::size_t> index;  // in the images folder
  std::vector<View> views;
  std::vector<Image8> images, masks;
  std::vector<BoardOdds> boards;
};

PosedImages Load(const ImageSet& set, const Scene& scene, const MasksOptions& options) {
  PosedImages posed;
  for (const View& view : scene.views) {
    const int found = set.Find(view.name);
    if (found < 0)
      throw InputError("masks: the model names " + view.name + ", which is not in " +
                       set.folder.string() + "; pass the images that the model was made from");
    posed.index.push_back(static_cast<std::size_t>(found));
    posed.views.push_back(view);
  }
  if (posed.views.size() < 3)
    throw InputError("masks: the model has fewer than 3 images; run sfm again");
  int longest = 1;
  for (const View& view : posed.views)
    longest = std::max({longest, view.camera.width, view.camera.height});
  constexpr double kBytesAPixel = 10;  // measured
  RequireMemoryForViews("masks", posed.views, std::min(1.0, 1.0 * options.mask_px / longest),
                        kBytesAPixel);
  posed.images.resize(posed.views.size());
  posed.masks.resize(posed.views.size());
  posed.boards.resize(posed.views.size());
  ParallelFor(std::ssize(posed.views), [&](std::int64_t k) {
    const auto i = static_cast<std::size_t>(k);
    const auto at = static_cast<int>(posed.index[i]);
    const Image8 image = ReadImage(set.ImagePath(at), 3), mask = ReadImage(set.MaskPath(at), 1);
    if (image.width != mask.width || image.height != mask.height ||
        image.width != posed.views[i].camera.width)
      throw InputError("masks: " + set.images[posed.index[i]].name +
                       ", its mask and its camera have different sizes; run capture and sfm again");
    posed.images[i] = WorkingImage(image, options.mask_px);
    posed.masks[i] = WorkingImage(mask, options.mask_px);
    for (std::uint8_t& m : posed.masks[i].data) m = m > 127 ? 255 : 0;
    const double factor = static_cast<double>(posed.images[i].width) / image.width;
    posed.views[i].camera = posed.views[i].camera.Scaled(factor);
    if (set.board)
      posed.boards[i] =
          OddsOfBoard(posed.images[i], set.images[posed.index[i]].board_corners, factor,
                      BoardPattern(*set.board, set.board_print), MaskOptions{}.odds_limit);
  });
  return posed;
}

double Mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value / static_cast<double>(values.size());
  return sum;
}

void ReportAgreement(StageContext& stage, const ImageSet& set, const PosedImages& posed,
                     const RefinedMasks& refined) {
  nlohmann::json each = nlohmann::json::object(), contrary = nlohmann::json::array();
  const std::vector<std::size_t> beyond = Touched(refined.consensus, {});
  for (std::size_t i = 0; i < refined.agreement.size(); ++i) {
    const std::string& name = set.images[posed.index[i]].name;
    each[name] = {refined.agreement_before[i], refined.agreement[i]};
    if (!refined.consensus.inlier[i] || std::count(beyond.begin(), beyond.end(), i) > 0)
      contrary.push_back(name);
  }
  stage.Report("agreement_before", Mean(refined.agreement_before));
  stage.Report("agreement", Mean(refined.agreement));
  stage.Report("least_agreement",
               *std::min_element(refined.agreement.begin(), refined.agreement.end()));
  stage.ReportJson("views_disagreeing", contrary.dump());
  stage.ReportJson("agreement_of_views", each.dump());
}

/// Describes for the user why a view is an outlier.
std::string WhyNot(const OutlineFit& fit, const ColorFit& color, const ColorOptions& options) {
  if (color.places >= options.least_places && color.contrary > options.most_contrary)
    return PercentHalfUp(color.contrary) +
           " of what it shows of the figure has other colours than the other photographs show "
           "there";
  const double missing = *std::max_element(std::begin(fit.missing), std::end(fit.missing));
  return "its outline leaves out " + PercentHalfUp(missing) +
         " of the figure that the other photographs agree on" +
         (fit.excess > 0.02 ? ", and " + PercentHalfUp(fit.excess) + " lies where they see past it"
                            : "");
}

/// Marks outlier photographs as not trusted, and warns.
/// @throws InputError  there are too many outliers for a reliable consensus
void ReportConsensus(StageContext& stage, const PosedImages& posed, const ViewConsensus& consensus,
                     ImageSet* set) {
  nlohmann::json distrusted = nlohmann::json::array(), fits = nlohmann::json::object();
  std::string names;
  for (std::size_t i = 0; i < consensus.inlier.size(); ++i) {
    CapturedImage& image = set->images[posed.index[i]];
    const OutlineFit& fit = consensus.fits[i];
    fits[image.name] = {{"missing", fit.missing},
                        {"excess", fit.excess},
                        {"other_colors", consensus.colors[i].contrary}};
    if (consensus.inlier[i]) continue;
    image.trusted = false;
    image.why = WhyNot(fit, consensus.colors[i], {});
    distrusted.push_back({{"name", image.name}, {"why", image.why}});
    names += (names.empty() ? "" : ", ") + image.name;
    stage.Warn(image.name + " contradicts the other photographs: " + image.why +
               "; it was left out of shape and texture. It shows something else, a moved figure or "
               "a hand, or its camera is wrong: shoot "
               "it again, "
               "or delete it");
  }
  stage.ReportJson("outline_fits", fits.dump());
  stage.ReportJson("distrusted", distrusted.dump());
  if (consensus.undecided)
    throw InputError(
        "masks: the photographs contradict each other in outline, and too many do to tell which "
        "are right (among them " +
        names +
        "): the figure or a part of it was moved between them, or cameras are wrong; keep the "
        "photographs from before the "
        "move or those from after it, and shoot the rest again");
}

/// Warns of the photographs in which a hand or another object touches the figure. In a room the
/// masks before this step's last rounds are guesses, of which much is cut off that touches nothing.
void ReportTouched(StageContext& stage, const ImageSet& set, const PosedImages& posed,
                   const RefinedMasks& refined, bool in_room) {
  nlohmann::json touched = nlohmann::json::array();
  std::string names;
  double largest = 0;
  for (const std::size_t i : Touched(refined.consensus_before, {})) {
    const std::string& name = set.images[posed.index[i]].name;
    const double excess = refined.consensus_before.fits[i].excess;
    touched.push_back({{"name", name}, {"share", excess}});
    if (!refined.consensus.inlier[i]) continue;
    names += (names.empty() ? "" : ", ") + name;
    largest = std::max(largest, excess);
  }
  if (!names.empty() && !in_room)
    stage.Warn("something touches the figure in " + names +
               " that the other photographs see past (a hand, a tool, a stand), as large as " +
               PercentHalfUp(largest) +
               " of the figure; it was cut off. If it is no stand, shoot such photographs again "
               "without, or delete them");
  stage.ReportJson("touched", touched.dump());
}

/// In a room only views tell what the figure is: a photograph without a camera keeps a guess, which
/// nothing may be made from.
void DistrustUnplaced(const PosedImages& posed, ImageSet* set) {
  std::vector<char> placed(set->images.size(), 0);
  for (const std::size_t i : posed.index) placed[i] = 1;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    CapturedImage& image = set->images[i];
    if (placed[i] || image.mask_given) continue;
    image.trusted = false;
    image.why = "it has no camera, so nothing tells the figure in it from the room";
  }
}

/// Where something stands before the figure, an outline would cut off what it hides: such
/// photographs keep their cameras, and nothing is made from them.
void DistrustHidden(StageContext& stage, const PosedImages& posed,
                    const std::vector<double>& hidden, ImageSet* set) {
  constexpr double kHides = 0.02;  // of the figure; less is within what outlines err by
  nlohmann::json photographs = nlohmann::json::array();
  std::string names;
  for (std::size_t v = 0; v < hidden.size(); ++v) {
    CapturedImage& image = set->images[posed.index[v]];
    if (hidden[v] < kHides || image.mask_given || !image.trusted) continue;
    image.trusted = false;
    image.why = "something before the figure hides " + PercentHalfUp(hidden[v]) + " of it";
    photographs.push_back({{"name", image.name}, {"share", hidden[v]}});
    names += (names.empty() ? "" : ", ") + image.name;
  }
  stage.ReportJson("hidden_behind_others", photographs.dump());
  if (!names.empty())
    stage.Warn("something stands before the figure and hides a part of it in " + names +
               "; they were left out of shape and texture. Photographs from there without it would "
               "show more");
}

void Copy(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::copy_file(from, to, fs::copy_options::overwrite_existing, error);
  if (error)
    throw DiskError("cannot copy " + from.string() + " to " + to.string() + ": " + error.message());
}

/// Writes one photograph and its mask, the old one if there is no better one.
/// @return cell of the contact sheet
Image8 WriteOne(const ImageSet& set, std::size_t i, const Image8* refined, const Backdrop* backdrop,
                const fs::path& folder, CapturedImage& entry) {
  Copy(set.ImagePath(static_cast<int>(i)), folder / entry.name);
  const Image8 image = ReadImage(set.ImagePath(static_cast<int>(i)), 3);
  Image8 mask = ReadImage(set.MaskPath(static_cast<int>(i)), 1);
  if (refined && !entry.mask_given) mask = RefinedMask(image, *refined, backdrop);
  entry.mask = "masks/" + entry.name + ".png";
  entry.mask_fraction = MaskFraction(mask);
  WriteImage(folder / entry.mask, mask);
  return ContactCell(image, mask, entry.name, kCellWidth);
}

void Run(StageContext& stage, const MasksOptions& options) {
  ImageSet set = ReadImageSet(stage.Input("images"));
  const Scene scene = ReadColmapModel(stage.Input("model"));
  ReportProgress(stage.progress(), 0, "reading photographs");
  PosedImages posed = Load(set, scene, options);
  SpaceOptions space = options.Space();
  const FigureSet figures{posed.views, scene.points, posed.images,      posed.boards,
                          posed.index, set,          options.Masking(), options.figure};
  const FoundFigure found = FindFigure(stage, figures, space, posed.masks);
  SubProgress progress(stage.progress(), 0.25, 0.7);
  const RefinedMasks refined = RefineInSpace(posed.images, posed.masks, posed.views, posed.boards,
                                             options.Masking(), space, &progress);
  ReportAgreement(stage, set, posed, refined);
  if (found.in_room) RequireClearFigure(stage, figures, space, found, refined.masks);
  ReportConsensus(stage, posed, refined.consensus, &set);
  ReportTouched(stage, set, posed, refined, found.in_room);
  DistrustHidden(stage, posed, found.hidden, &set);
  if (found.in_room) DistrustUnplaced(posed, &set);
  const fs::path folder = stage.Output("masked");
  fs::create_directories(folder / "masks");
  std::vector<const Image8*> mask_of(set.images.size(), nullptr);
  std::vector<const Backdrop*> backdrop_of(set.images.size(), nullptr);
  for (std::size_t i = 0; i < refined.masks.size(); ++i) {
    mask_of[posed.index[i]] = &refined.masks[i];
    backdrop_of[posed.index[i]] = &refined.backdrops[i];
  }
  std::vector<Image8> cells(set.images.size());
  ReportProgress(stage.progress(), 0.7, "writing images and masks");
  ParallelFor(std::ssize(cells), [&](std::int64_t k) {
    const auto i = static_cast<std::size_t>(k);
    cells[i] = WriteOne(set, i, mask_of[i], backdrop_of[i], folder, set.images[i]);
  });
  set.folder = folder;
  if (std::isfinite(space.floor)) set.floor = space.floor;
  WriteImageSet(set);
  WriteImage(folder / "contact_sheet.jpg", ContactSheet(cells));
}

const StageSpec kSpec = {
    .name = "masks",
    .version = "21",
    .summary =
        "Segments the photographs again, with masks that are consistent between all "
        "views.",
    .title = "Masks",
    .measurements = {{"agreement", "masks' overlap with their hull"},
                     {"least_agreement", "least of a view"}},
    .inputs = {{.name = "images",
                .kind = "folder",
                .help = "photographs and masks, as capture makes them",
                .file = ""},
               {.name = "model",
                .kind = "folder",
                .help = "COLMAP model of the cameras, as sfm makes it",
                .file = ""}},
    .outputs = {{.name = "masked",
                 .kind = "folder",
                 .help = "the same with better masks",
                 .file = "masked"}},
    .tools = {},
    .shared_files = {kSalienceFile},
    .cores = 0,
    .memory_gib = 1.5};

}  // namespace

int main(int argc, char** argv) { return RunStage<MasksOptions>(argc, argv, kSpec, Run); }
