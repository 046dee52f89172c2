// keypose-capture: a folder of photographs to checked images with masks.
#include <algorithm>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <numeric>

#include "capture/board/board_detection.h"
#include "capture/board/board_print.h"
#include "capture/board_to_find.h"
#include "capture/capture_options.h"
#include "capture/find_photographs.h"
#include "capture/other_things.h"
#include "capture/own_mask_import.h"
#include "capture/photograph_import.h"
#include "capture/pictures/contact_sheet.h"
#include "capture/pictures/overlap.h"
#include "capture/pictures/photograph_quality.h"
#include "capture/pictures/working_image.h"
#include "capture/said_figure.h"
#include "capture/segmentation/masking.h"
#include "core/io/pictures/blurred_images.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/io/pictures/other_thing_notes.h"
#include "core/io/pictures/reduced_image.h"
#include "core/io/text/files.h"
#include "core/numbers/statistics.h"
#include "core/stage/stage.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace {
using namespace keypose;
using namespace keypose::capture;

constexpr int kCellWidth = 240;
constexpr int kPreview_px = 640;
// for more photographs, comparing all pairs would take too long
constexpr std::size_t kMostCompared = 60;

/// Eighths that suffice for the working image; ordinary photographs are decoded whole.
int SegmentedEighths(const PhotographImport& import, std::size_t i, const CaptureOptions& options) {
  if (DetailEighths(import, i) == 8) return 8;
  const Size size = WrittenSize(import, i);
  return EighthsFor(size.width, size.height, 2 * options.mask_px);
}

/// Decodes everything once, which also detects truncated files, and searches the calibration board.
void DecodeAll(StageContext& stage, PhotographImport& import, const CaptureOptions& options) {
  if (options.LooksForBoard()) import.board = BoardToFind(stage, import, options);
  const bool with_board = import.board.has_value();
  import.small.resize(import.files.size());
  import.board_corners.resize(import.files.size());
  import.boards.resize(import.files.size());
  ForEachPhotograph(import, stage.progress(), "cannot be used", [&](std::size_t i) {
    const int eighths =
        with_board ? DetailEighths(import, i) : SegmentedEighths(import, i, options);
    const Image8 image = LoadReduced(import, i, eighths);
    import.small[i] = WorkingImage(image, options.mask_px);
    if (!with_board) return;
    std::vector<BoardCorner>& corners = import.board_corners[i];
    corners = CornersOf(image, *import.board);
    import.boards[i] = OddsOfBoard(import.small[i], corners,
                                   static_cast<double>(import.small[i].width) / image.width,
                                   *import.board, options.Masking().odds_limit);
    for (BoardCorner& corner : corners) corner.pixel *= 8.0 / eighths;
  });
}

/// Segments some photographs together. Where a person said what the figure is, that chooses.
void Segment(StageContext& stage, PhotographImport& import, const std::vector<std::size_t>& members,
             const Image8& clean_plate, const MaskOptions& masking, Progress* progress) {
  std::vector<Image8> images;
  std::vector<BoardOdds> boards;
  std::vector<char> said;
  for (const std::size_t i : members) {
    images.push_back(std::move(import.small[i]));
    boards.push_back(import.boards[i]);
    said.push_back(!import.strokes[i].empty());
  }
  std::vector<Image8> masks = SegmentSet(images, clean_plate, boards, masking, progress, said);
  for (std::size_t k = 0; k < members.size(); ++k) {
    const std::size_t i = members[k];
    import.small_masks[i] = said[k] ? SaidMask(stage, import.photographs[i].name, images[k],
                                               masks[k], import.strokes[i])
                                    : std::move(masks[k]);
  }
}

/// Takes those photographs out of `members` that a clean plate of this size does not fit; none if
/// it has no photograph's size: then its shape alone is compared, with all.
std::vector<std::size_t> TakeOutOthers(const PhotographImport& import, const Image8& plate,
                                       std::vector<std::size_t>& members) {
  const auto fits = [&](std::size_t i) {
    const bool turned = import.quarter_turns[i] != 0;
    const Photograph& photograph = import.photographs[i];
    return plate.width == (turned ? photograph.height : photograph.width) &&
           plate.height == (turned ? photograph.width : photograph.height);
  };
  std::vector<std::size_t> others;
  if (std::none_of(members.begin(), members.end(), fits)) return others;
  for (const std::size_t i : members)
    if (!fits(i)) others.push_back(i);
  std::erase_if(members, [&](std::size_t i) { return !fits(i); });
  return others;
}

/// Segments the photographs of one placement. What has another size than the clean plate is of
/// another camera and segmented without it.
void SegmentPlacement(StageContext& stage, PhotographImport& import, std::size_t placement,
                      std::vector<std::size_t> members, const MaskOptions& masking,
                      Progress* progress) {
  Image8 clean_plate;
  std::vector<std::size_t> others;
  if (!import.backgrounds[placement].empty()) {
    clean_plate = LoadPlate(import, placement);
    others = TakeOutOthers(import, clean_plate, members);
    clean_plate = WorkingImage(clean_plate, masking.working_px);
  }
  Segment(stage, import, members, clean_plate, masking, progress);
  if (others.empty()) return;
  std::vector<std::string> names;
  for (const std::size_t i : others) names.push_back(import.photographs[i].name);
  stage.Warn(
      "the clean plate has another size than these photographs, which are masked without "
      "it: " +
      JoinNames(names));
  Segment(stage, import, others, {}, masking, progress);
}

/// Segments the groups unless all masks are given: each placement has its own light and its own
/// empty set.
void SegmentAll(StageContext& stage, PhotographImport& import, const CaptureOptions& options) {
  import.small_masks.resize(import.files.size());
  import.strokes = StrokesIn(stage, import, options.figure);
  stage.Report("figure_strokes",
               static_cast<int>(std::count_if(import.strokes.begin(), import.strokes.end(),
                                              [](const ViewStrokes& of) { return !of.empty(); })));
  if (std::none_of(import.user_masks.begin(), import.user_masks.end(),
                   [](const fs::path& mask) { return mask.empty(); }))
    return;
  std::size_t begin = 0;
  for (std::size_t g = 0; g < import.groups.size(); ++g) {
    std::vector<std::size_t> members(import.groups[g].files.size());
    std::iota(members.begin(), members.end(), begin);
    const std::size_t end = begin + members.size();
    const auto share = [&](std::size_t i) {
      return 0.2 + 0.5 * static_cast<double>(i) / static_cast<double>(import.files.size());
    };
    SubProgress progress(stage.progress(), share(begin), share(end));
    SegmentPlacement(stage, import, g, std::move(members), options.Masking(), &progress);
    begin = end;
  }
}

struct Written {
  CapturedImage image;
  PhotographQuality quality;
  Image8 cell;
  Preview preview;
};

CapturedImage EntryOf(const PhotographImport& import, std::size_t i,
                      const MaskedPhotograph& masked) {
  const Photograph& photograph = import.photographs[i];
  CapturedImage entry;
  entry.name = photograph.name;
  entry.width = masked.size.width;
  entry.height = masked.size.height;
  if (photograph.width != entry.width || photograph.height != entry.height) {
    entry.photograph_width = photograph.width;
    entry.photograph_height = photograph.height;
  }
  entry.focal_px = photograph.focal_px * import.factors[i];
  entry.mask = "masks/" + entry.name + ".png";
  entry.mask_fraction = MaskFraction(masked.detail_mask);
  entry.mask_given = !import.user_masks[i].empty();
  entry.group = photograph.group;
  entry.place = PlaceOf(import, i);
  entry.board_corners = import.board_corners[i];
  return entry;
}

Written WriteOne(const PhotographImport& import, std::size_t i, const fs::path& folder,
                 const CaptureOptions& options) {
  const std::string& name = import.photographs[i].name;
  Image8 own;
  if (!import.user_masks[i].empty()) own = LoadOwnMask(import, i);
  const MaskedPhotograph masked =
      WriteMasked(import, i, std::move(own), folder / name, folder / "masks" / (name + ".png"),
                  options.jpeg_quality);
  const Image8 &image = masked.detail, &mask = masked.detail_mask, grey = Grey(image);
  Written written;
  written.image = EntryOf(import, i, masked);
  // Sharpness is measured at a size at which any camera in focus is sharp.
  written.quality = MeasureQuality(WorkingImage(grey, options.sharpness_px),
                                   WorkingImage(mask, options.sharpness_px));
  written.image.sharpness = written.quality.laplacian_variance;
  written.image.crispness = written.quality.crispness;
  written.image.exposure = written.quality.exposure;
  if (import.files.size() <= kMostCompared)
    written.preview = {WorkingImage(grey, kPreview_px), WorkingImage(mask, kPreview_px)};
  written.cell = ContactCell(image, mask, name, kCellWidth);
  return written;
}

std::vector<std::string> NamesWhere(const std::vector<Written>& all,
                                    const std::function<bool(const Written&)>& condition) {
  std::vector<std::string> names;
  for (const Written& written : all)
    if (condition(written)) names.push_back(written.image.name);
  return names;
}

double MedianCrispness(const std::vector<Written>& all) {
  std::vector<double> crispness;
  for (const Written& written : all) crispness.push_back(written.quality.crispness);
  return UpperMedian(std::move(crispness));
}

/// A few bad photographs are only reported; many are an error.
void RequireFitSet(StageContext& stage, const std::vector<Written>& all,
                   const CaptureOptions& options) {
  const auto is_black = [&](const Written& w) { return w.image.mask_fraction < options.min_mask; };
  const auto black = NamesWhere(all, is_black);
  // Without a figure there is nothing that could be sharp.
  const auto blurred_below = [&](double crispness) {
    return NamesWhere(
        all, [&](const Written& w) { return !is_black(w) && w.quality.crispness < crispness; });
  };
  const auto unusable = blurred_below(options.min_sharpness);
  const auto blurred =
      options.min_sharpness > 0
          ? blurred_below(std::max(options.min_sharpness, kBlurredOfMedian * MedianCrispness(all)))
          : unusable;
  const auto limit =
      static_cast<std::size_t>(options.max_bad_share * static_cast<double>(all.size()));
  stage.ReportJson("blurred", nlohmann::json(blurred).dump());
  if (!blurred.empty() && unusable.size() <= limit)
    stage.Warn("these photographs are blurred, and what only they show will be coarse: " +
               JoinNames(blurred) +
               "; leave them out where others show the same, or shoot them again with a tripod, a "
               "smaller aperture and fixed focus");
  stage.ReportJson("empty_masks", nlohmann::json(black).dump());
  if (!black.empty() && black.size() <= limit)
    stage.Warn(
        "no figure was found in these photographs: " + JoinNames(black) +
        "; if they show it, paint its mask or say by a click where it is; else take them out "
        "of the folder");
  if (black.size() > limit)
    throw InputError("capture: the masks of " + std::to_string(black.size()) + " of " +
                     std::to_string(all.size()) +
                     " photographs are black (no object found): " + JoinNames(black) +
                     "; give a photograph of the empty set as --background, or masks (white where "
                     "the object is) as --masks");
  if (unusable.size() > limit)
    throw InputError("capture: " + std::to_string(unusable.size()) + " of " +
                     std::to_string(all.size()) +
                     " photographs are blurred: " + JoinNames(unusable) +
                     "; use a tripod, a smaller aperture and fixed focus and shoot them again, or "
                     "lower --min_sharpness (now " +
                     nlohmann::json(options.min_sharpness).dump() + ")");
}

/// Warns of problems that a person can still correct at this time: too few photographs, or too far
/// apart. The final decision is made in sfm.
void JudgeSpacing(StageContext& stage, std::vector<Written>& all, std::size_t groups) {
  constexpr std::size_t kFew = 16;
  if (all.size() < kFew)
    stage.Warn("there are only " + std::to_string(all.size()) +
               " photographs; without the printed calibration board a turn needs 24 of them, 15 "
               "degrees apart, unless the figure is rich in texture");
  if (all.size() > kMostCompared || groups > 1) return;
  std::vector<Preview> previews;
  for (Written& written : all) previews.push_back(std::move(written.preview));
  constexpr int kStrong = 40;  // of the at most 400 features of a preview
  const auto images = SizeOf(all);
  const std::vector<ImageTie> ties = SharedPlaces(previews, stage.progress());
  const auto joined = JoinedImages(images, ties);
  stage.Report("spacing_ties", SizeOf(ties));
  stage.Report("spacing_groups", SizeOf(joined));
  if (!FallsApart(images, ties, kStrong)) return;
  std::vector<std::string> names;
  for (const int i : joined[0]) names.push_back(all[i].image.name);
  stage.Warn("neighbouring photographs share hardly any places: the " + std::to_string(images) +
             " photographs fall into " + std::to_string(joined.size()) + " groups, such as " +
             JoinNames(names) + ", as if the table was turned by about " +
             std::to_string(360 / SizeOf(joined)) +
             " degrees at a time; turn it by 15 degrees at most, or sfm may find no cameras");
}

int BoardViews(const PhotographImport& import) {
  return static_cast<int>(std::count_if(import.board_corners.begin(), import.board_corners.end(),
                                        [](const auto& corners) { return !corners.empty(); }));
}

void ReportBoard(StageContext& stage, const PhotographImport& import) {
  const int views = BoardViews(import);
  stage.Report("board_views", views);
  if (views == 0) return;
  double corners = 0;
  nlohmann::json without = nlohmann::json::array();
  for (std::size_t i = 0; i < import.board_corners.size(); ++i) {
    corners += static_cast<double>(import.board_corners[i].size());
    if (import.board_corners[i].empty()) without.push_back(import.photographs[i].name);
  }
  stage.Report("board", import.board->Text());
  stage.Report("board_mean_corners", corners / views);
  stage.ReportJson("plate_not_seen", without.dump());
}

bool FocalKnown(const PhotographImport& import) {
  return std::any_of(import.photographs.begin(), import.photographs.end(),
                     [](const Photograph& p) { return p.focal_px > 0; });
}

/// The sizes written, the most common one first, where there are several.
void ReportSizes(StageContext& stage, const PhotographImport& import) {
  stage.Report("sizes", SizeOf(import.sizes));
  if (import.sizes.size() < 2) return;
  nlohmann::json each = nlohmann::json::array();
  for (const SizeGroup& group : import.sizes) {
    const Size size = WrittenSize(import, group.photographs.front());
    each.push_back({{"width", size.width},
                    {"height", size.height},
                    {"photographs", SizeOf(group.photographs)}});
  }
  stage.ReportJson("images_by_size", each.dump());
}

/// What the user gave beside the photographs, and their placements.
void ReportGiven(StageContext& stage, const PhotographImport& import) {
  stage.Report("user_masks",
               static_cast<int>(std::count_if(import.user_masks.begin(), import.user_masks.end(),
                                              [](const auto& m) { return !m.empty(); })));
  stage.Report("clean_plate", std::any_of(import.backgrounds.begin(), import.backgrounds.end(),
                                          [](const fs::path& file) { return !file.empty(); }));
  if (import.groups.size() > 1) {
    nlohmann::json groups;
    for (const PhotographGroup& group : import.groups) groups[group.name] = group.files.size();
    stage.ReportJson("groups", groups.dump());
  }
}

void ReportSet(StageContext& stage, const PhotographImport& import,
               const std::vector<Written>& all) {
  double sharpness = 0, exposure = 0, clipped = 0, fraction = 0;
  nlohmann::json each = nlohmann::json::array();
  for (const Written& w : all) {
    sharpness += w.quality.crispness / static_cast<double>(all.size());
    exposure += w.quality.exposure / static_cast<double>(all.size());
    clipped += w.quality.clipped / static_cast<double>(all.size());
    fraction += w.image.mask_fraction / static_cast<double>(all.size());
    each.push_back({{"name", w.image.name},
                    {"sharpness", w.quality.crispness},
                    {"exposure", w.quality.exposure},
                    {"mask_fraction", w.image.mask_fraction}});
  }
  stage.Report("images", SizeOf(all));
  const SizeGroup& most = import.sizes.front();
  const std::size_t usual = most.photographs.front();
  stage.Report("width", WrittenSize(import, usual).width);
  stage.Report("height", WrittenSize(import, usual).height);
  ReportSizes(stage, import);
  stage.Report("camera_model", import.photographs.front().camera_model);
  stage.Report("focal_known", FocalKnown(import));
  stage.Report("focal_px", MedianFocalPx(import.photographs, most) * import.factors[usual]);
  stage.Report("focal_spread", FocalSpread(import.photographs, import.sizes));
  stage.Report("turned", static_cast<int>(std::count(import.quarter_turns.begin(),
                                                     import.quarter_turns.end(), 1)));
  ReportGiven(stage, import);
  stage.Report("mean_sharpness", sharpness);
  stage.Report("mean_exposure", exposure);
  stage.Report("mean_clipped", clipped);
  stage.Report("mean_mask_fraction", fraction);
  stage.ReportJson("photographs", each.dump());
}

void Run(StageContext& stage, const CaptureOptions& options) {
  PhotographImport import = OpenPhotographs(stage, options);
  FindWaysOfMasks(stage, &import);
  ReportProgress(stage.progress(), 0.05, "reading photographs");
  DecodeAll(stage, import, options);
  const std::vector<SetAside> aside = SetOtherThingsAside(stage, &import, options);
  SegmentAll(stage, import, options);
  const fs::path folder = stage.Output("images");
  fs::create_directories(folder / "masks");
  std::vector<Written> written(import.files.size());
  ReportProgress(stage.progress(), 0.7, "writing images and masks");
  ForEachPhotograph(import, stage.progress(), "cannot be used",
                    [&](std::size_t i) { written[i] = WriteOne(import, i, folder, options); });
  ReportSet(stage, import, written);
  ReportBoard(stage, import);
  RequireFitSet(stage, written, options);
  if (BoardViews(import) == 0 && IsOfAScan(options.min_images))
    JudgeSpacing(stage, written, import.groups.size());
  ImageSet set;
  set.folder = folder;
  set.camera_model = import.photographs.front().camera_model;
  if (BoardViews(import) > 0) {
    set.board = import.board->layout;
    set.board_print = *import.board;
  }
  std::vector<Image8> cells;
  for (Written& w : written) {
    set.images.push_back(std::move(w.image));
    cells.push_back(std::move(w.cell));
  }
  std::sort(set.images.begin(), set.images.end(),
            [](const auto& a, const auto& b) { return a.name < b.name; });
  WriteImageSet(set);
  OtherThingNotes left_out;
  for (const SetAside& one : aside) {
    left_out[one.name] = one.why;
    cells.push_back(LeftOutCell(one.small, one.name + ": left out", kCellWidth));
  }
  WriteOtherThingNotes(folder, left_out);
  WriteImage(folder / "contact_sheet.jpg", ContactSheet(cells));
  if (!FocalKnown(import))
    stage.Note("capture: no focal length in the EXIF data; sfm starts from a guess and refines it");
}

void PrintBoard(const fs::path& file, const CaptureOptions& options) {
  const BoardPattern board = options.Board();
  if (!IsOwnPrint(board, board.layout))
    throw UsageError("capture prints boards of " + DictionaryName(kOwnDictionary) +
                     " alone, the first square black, not " + board.Name() +
                     "; leave dictionary and layout out of --board");
  WriteFileAtomically(file, BoardPdf(board.layout, PageNamed(options.board_page)));
}

const StageSpec kSpec = {
    .name = "capture",
    .version = "16",
    .summary = "Imports and checks photographs of one pose and masks the object in each.",
    .title = "Photographs",
    .measurements = {{"images_total", "photographs"},
                     {"images", "photographs used"},
                     {"mean_sharpness", "mean sharpness", "", 0.4}},
    .inputs = {{.name = "photos",
                .kind = "folder",
                .help = "photographs of one pose: JPEG, PNG, TIFF, HEIC or RAW; or subfolders, one "
                        "for each placement (upright, lying)",
                .file = ""},
               {.name = "masks",
                .kind = "folder",
                .help = "masks of your own, white where the object is, named like the photographs",
                .file = "",
                .optional = true},
               {.name = "background",
                .kind = "file",
                .help = "a photograph of the empty set, same camera settings",
                .file = "",
                .optional = true}},
    .outputs = {{.name = "images",
                 .kind = "folder",
                 .help = "photographs, masks/, capture.json, contact_sheet.jpg",
                 .file = "images"}},
    .tools = {},
    .cores = 0,
    .memory_gib = 1,
    .common = {"max_size", "min_images", "min_sharpness", "board", "board_page"}};

}  // namespace

int main(int argc, char** argv) {
  return RunStage<CaptureOptions>(
      argc, argv, kSpec, Run,
      {{"print-board",
        "write the printable calibration board (PDF) to this file and stop; see --board_page",
        PrintBoard}});
}
