// keypose-capture: a folder of photographs to checked images with masks.
#include <algorithm>
#include <atomic>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>

#include "capture/board/board_detection.h"
#include "capture/board/board_print.h"
#include "capture/capture_options.h"
#include "capture/photograph_import.h"
#include "capture/photographs.h"
#include "capture/pictures/contact_sheet.h"
#include "capture/pictures/overlap.h"
#include "capture/pictures/quality.h"
#include "capture/pictures/working_image.h"
#include "capture/segmentation/masking.h"
#include "core/errors.h"
#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/io/image_set.h"
#include "core/io/reduced_image.h"
#include "core/parallel.h"
#include "core/size_of.h"
#include "core/stage/stage.h"

namespace {
using namespace keypose;
using namespace keypose::capture;

constexpr int kCellWidth = 240;
constexpr int kPreview_px = 640;
// for more photographs, comparing all pairs would take too long
constexpr std::size_t kMostCompared = 60;

/// Whether some photographs, spread over the set, show the calibration board.
bool ShowsBoard(const PhotographImport& import, const CaptureOptions& options) {
  constexpr std::size_t kProbes = 8;
  const std::size_t probes = std::min(kProbes, import.files.size());
  std::atomic<bool> seen = false;
  ParallelFor(static_cast<std::int64_t>(probes), [&](std::int64_t k) {
    if (seen) return;
    const std::size_t i = static_cast<std::size_t>(k) * import.files.size() / probes;
    try {
      const Image8 image = LoadReduced(import, i, DetailEighths(import, i));
      if (!FindBoard(image, options.Board()).empty()) seen = true;
    } catch (const InputError&) {
      // A damaged photograph is reported later, with all the others.
    }
  });
  return seen;
}

/// Eighths that suffice for the working image; ordinary photographs are decoded whole.
int SegmentedEighths(const PhotographImport& import, std::size_t i, const CaptureOptions& options) {
  if (DetailEighths(import, i) == 8) return 8;
  const Size size = WrittenSize(import, i);
  return EighthsFor(size.width, size.height, 2 * options.mask_px);
}

/// Decodes everything once, which also detects truncated files, and searches the calibration board.
void DecodeAll(StageContext& stage, PhotographImport& import, const CaptureOptions& options) {
  const bool with_board = options.board && ShowsBoard(import, options);
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
    corners = FindBoard(image, options.Board());
    import.boards[i] = OddsOfBoard(import.small[i], corners,
                                   static_cast<double>(import.small[i].width) / image.width,
                                   options.Board(), options.Masking().odds_limit);
    for (BoardCorner& corner : corners) corner.pixel *= 8.0 / eighths;
  });
}

/// Segments the groups unless all masks are given: each placement has its own light and its own
/// empty set.
void SegmentAll(StageContext& stage, PhotographImport& import, const CaptureOptions& options) {
  const MaskOptions masking = options.Masking();
  import.small_masks.resize(import.files.size());
  if (std::none_of(import.user_masks.begin(), import.user_masks.end(),
                   [](const fs::path& mask) { return mask.empty(); }))
    return;
  std::size_t begin = 0;
  for (std::size_t g = 0; g < import.groups.size(); ++g) {
    const std::size_t end = begin + import.groups[g].files.size();
    Image8 clean_plate;
    if (!import.backgrounds[g].empty())
      clean_plate = WorkingImage(LoadPlate(import, g), masking.working_px);
    const auto share = [&](std::size_t i) {
      return 0.2 + 0.5 * static_cast<double>(i) / static_cast<double>(import.files.size());
    };
    SubProgress progress(stage.progress(), share(begin), share(end));
    const std::vector<Image8> images(
        std::make_move_iterator(import.small.begin() + static_cast<std::ptrdiff_t>(begin)),
        std::make_move_iterator(import.small.begin() + static_cast<std::ptrdiff_t>(end)));
    const std::vector<BoardOdds> boards(import.boards.begin() + static_cast<std::ptrdiff_t>(begin),
                                        import.boards.begin() + static_cast<std::ptrdiff_t>(end));
    auto masks = SegmentSet(images, clean_plate, boards, masking, &progress);
    std::move(masks.begin(), masks.end(),
              import.small_masks.begin() + static_cast<std::ptrdiff_t>(begin));
    begin = end;
  }
}

struct Written {
  CapturedImage image;
  Quality quality;
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
  entry.focal_px = photograph.focal_px * import.factor;
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
  const MaskedPhotograph masked = WriteMasked(
      import, i, folder / name, folder / "masks" / (name + ".png"), options.jpeg_quality);
  const Image8 &image = masked.detail, &mask = masked.detail_mask, grey = Grey(image);
  Written written;
  written.image = EntryOf(import, i, masked);
  // Sharpness is measured at a size at which any camera in focus is sharp.
  written.quality = MeasureQuality(WorkingImage(grey, options.sharpness_px),
                                   WorkingImage(mask, options.sharpness_px));
  written.image.sharpness = written.quality.laplacian_variance;
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

/// A few bad photographs are only reported; many are an error.
void RequireFitSet(StageContext& stage, const std::vector<Written>& all,
                   const CaptureOptions& options) {
  const auto blurred = NamesWhere(
      all, [&](const Written& w) { return w.quality.crispness < options.min_sharpness; });
  const auto black =
      NamesWhere(all, [&](const Written& w) { return w.image.mask_fraction < options.min_mask; });
  const auto limit =
      static_cast<std::size_t>(options.max_bad_share * static_cast<double>(all.size()));
  stage.ReportJson("blurred", nlohmann::json(blurred).dump());
  if (!blurred.empty() && blurred.size() <= limit)
    stage.Warn("these photographs are blurred, and what only they show will be coarse: " +
               JoinNames(blurred) +
               "; shoot them again with a tripod, a smaller aperture and fixed focus");
  stage.ReportJson("empty_masks", nlohmann::json(black).dump());
  if (black.size() > limit)
    throw InputError("capture: the masks of " + std::to_string(black.size()) + " of " +
                     std::to_string(all.size()) +
                     " photographs are black (no object found): " + JoinNames(black) +
                     "; give a photograph of the empty set as --background, or masks (white where "
                     "the object is) as --masks");
  if (blurred.size() > limit)
    throw InputError("capture: " + std::to_string(blurred.size()) + " of " +
                     std::to_string(all.size()) +
                     " photographs are blurred: " + JoinNames(blurred) +
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
  stage.Report("board_mean_corners", corners / views);
  stage.ReportJson("plate_not_seen", without.dump());
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
  stage.Report("width", all.front().image.width);
  stage.Report("height", all.front().image.height);
  stage.Report("camera_model", import.photographs.front().camera_model);
  stage.Report("focal_known", MedianFocalPx(import.photographs) > 0);
  stage.Report("focal_px", MedianFocalPx(import.photographs) * import.factor);
  stage.Report("focal_spread", FocalSpread(import.photographs));
  stage.Report("turned", static_cast<int>(std::count(import.quarter_turns.begin(),
                                                     import.quarter_turns.end(), 1)));
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
  stage.Report("mean_sharpness", sharpness);
  stage.Report("mean_exposure", exposure);
  stage.Report("mean_clipped", clipped);
  stage.Report("mean_mask_fraction", fraction);
  stage.ReportJson("photographs", each.dump());
}

void Run(StageContext& stage, const CaptureOptions& options) {
  PhotographImport import = OpenPhotographs(stage, options);
  ReportProgress(stage.progress(), 0.05, "reading photographs");
  DecodeAll(stage, import, options);
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
  if (BoardViews(import) > 0) set.board = options.Board();
  std::vector<Image8> cells;
  for (Written& w : written) {
    set.images.push_back(std::move(w.image));
    cells.push_back(std::move(w.cell));
  }
  std::sort(set.images.begin(), set.images.end(),
            [](const auto& a, const auto& b) { return a.name < b.name; });
  WriteImageSet(set);
  WriteImage(folder / "contact_sheet.jpg", ContactSheet(cells));
  if (MedianFocalPx(import.photographs) <= 0)
    stage.Note("capture: no focal length in the EXIF data; sfm starts from a guess and refines it");
}

void PrintBoard(const fs::path& file, const CaptureOptions& options) {
  WriteFileAtomically(file, BoardPdf(options.Board(), PageNamed(options.board_page)));
}

const StageSpec kSpec = {
    .name = "capture",
    .version = "9",
    .summary = "Imports and checks photographs of one pose and masks the object in each.",
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
