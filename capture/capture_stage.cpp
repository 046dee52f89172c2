// keypose-capture: a folder of photographs to checked images with masks.
#include <algorithm>
#include <filesystem>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>

#include "capture/board/board_detection.h"
#include "capture/board/board_print.h"
#include "capture/capture_options.h"
#include "capture/photographs.h"
#include "capture/pictures/contact_sheet.h"
#include "capture/pictures/overlap.h"
#include "capture/pictures/quality.h"
#include "capture/pictures/working_image.h"
#include "capture/segmentation/masking.h"
#include "capture/shoot/develop/photograph.h"
#include "capture/shoot/develop/white_balance.h"
#include "capture/shoot/record/side_file.h"
#include "core/errors.h"
#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/io/image_set.h"
#include "core/io/photograph_files.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "core/size_of.h"
#include "core/stage/stage.h"

namespace {
namespace fs = std::filesystem;
using namespace keypose;
using namespace keypose::capture;

constexpr int kCellWidth = 240;
constexpr int kPreview_px = 640;

/// The set during import.
struct Import {
  fs::path folder, masks;  // masks: empty if the user gave none
  std::vector<PhotographGroup> groups;
  std::vector<fs::path> backgrounds;  // for each group; empty if the user gave none
  std::vector<fs::path> files;        // of all groups
  std::vector<Photograph> photographs;
  std::vector<char> quarter_turns;
  double factor = 1;  // size written over size read
  // of each group's folder; none for photographs that `keypose shoot` has not made
  std::map<fs::path, shoot::SideFile> side_files;
  std::vector<Image8> small;  // working images
  std::vector<Image8> small_masks;
  std::vector<fs::path> user_masks;
  // for each photograph; empty if it shows no board
  std::vector<std::vector<BoardCorner>> board_corners;
  std::vector<BoardOdds> boards;  // their odds for the working images
};

Image8 QuarterTurned(const Image8& image) {
  Image8 turned(image.height, image.width, image.channels);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      std::copy_n(image.at(x, y), image.channels, turned.at(image.height - 1 - y, x));
  return turned;
}

/// What `keypose shoot` has noted of the photograph's folder; null for photographs of another
/// origin.
const shoot::SideFile* SideFileOf(const Import& import, std::size_t i) {
  const auto side = import.side_files.find(import.files[i].parent_path());
  return side == import.side_files.end() ? nullptr : &side->second;
}

/// The photograph, with the white balance of its session's grey card if there is one.
Image8 ReadBalanced(const Import& import, std::size_t i) {
  Image8 image = shoot::ReadPhotograph(import.files[i]);
  const shoot::SideFile* side = SideFileOf(import, i);
  return side && side->white ? shoot::WithGains(image, side->white->gains) : image;
}

/// The photograph's place in its session.
std::optional<TurntablePlace> PlaceOf(const Import& import, std::size_t i) {
  const shoot::SideFile* side = SideFileOf(import, i);
  if (!side) return std::nullopt;
  const auto shot = shoot::ShotNamed(side->plan, import.files[i].stem().string());
  if (!shot) return std::nullopt;
  return TurntablePlace{shot->ring, shoot::AngleOf(side->plan, *shot),
                        shoot::TiltOf(side->plan, *shot), shot->flip};
}

/// Pixels as they will be written: upright, of one size.
Image8 Load(const Import& import, std::size_t i, const fs::path& file, int channels) {
  Image8 image = channels == 3 ? ReadBalanced(import, i) : ReadImage(file, channels);
  const Photograph& photograph = import.photographs[i];
  if (image.width != photograph.width || image.height != photograph.height)
    throw InputError("capture: mask " + file.string() + " is " + std::to_string(image.width) +
                     " x " + std::to_string(image.height) + ", but " + photograph.name + " is " +
                     std::to_string(photograph.width) + " x " + std::to_string(photograph.height) +
                     "; make the mask at the photograph's size");
  if (import.quarter_turns[i]) image = QuarterTurned(image);
  if (import.factor == 1) return image;
  return Resized(image, std::max(1, static_cast<int>(std::lround(image.width * import.factor))),
                 std::max(1, static_cast<int>(std::lround(image.height * import.factor))));
}

/// Calls body(i) for all photographs in parallel and collects the errors.
void ForEach(const Import& import, Progress* progress, const std::string& what,
             const std::function<void(std::size_t)>& body) {
  std::vector<std::string> faults(import.files.size());
  ParallelFor(std::ssize(import.files), [&](std::int64_t i) {
    if (progress && progress->cancelled()) throw Cancelled();
    try {
      body(static_cast<std::size_t>(i));
    } catch (const InputError& error) {
      faults[i] = error.what();
    }
  });
  std::erase(faults, "");
  if (faults.size() == 1) throw InputError(faults.front());
  if (!faults.empty())
    throw InputError("capture: " + std::to_string(faults.size()) + " files " + what + ":\n  " +
                     JoinNames(faults, 200));
}

/// Each photograph in progress takes many times its pixels (measured: 90 bytes each, most for the
/// board and the mask). If there is not enough memory for one per core, fewer are processed at a
/// time; the result is the same.
void FitIntoMemory(StageContext& stage, const Import& import) {
  constexpr std::int64_t kBytesAPixel = 90;
  std::size_t largest = 0;
  const auto pixels = [&](std::size_t i) {
    return std::int64_t{import.photographs[i].width} * import.photographs[i].height;
  };
  for (std::size_t i = 1; i < import.photographs.size(); ++i)
    if (pixels(i) > pixels(largest)) largest = i;
  const std::int64_t need = kBytesAPixel * pixels(largest);
  const Photograph& photograph = import.photographs[largest];
  RequireMemory(need, "capture: photograph " + photograph.name + " (" +
                          std::to_string(photograph.width) + " x " +
                          std::to_string(photograph.height) + " pixels)");
  const std::int64_t at_once = FreeMemory() / std::max<std::int64_t>(1, need);
  if (at_once >= ThreadCount()) return;
  SetThreadCount(static_cast<int>(std::max<std::int64_t>(1, at_once)));
  stage.Note("capture: memory for " + std::to_string(ThreadCount()) + " photographs at a time");
}

/// Reports user masks with other names, so that none is ignored silently.
void RequireMasksOfPhotographs(StageContext& stage, const Import& import) {
  if (import.masks.empty()) return;
  std::vector<std::string> strangers, doubles;
  for (const fs::path& file : ImagesIn(import.masks)) {
    if (std::find(import.user_masks.begin(), import.user_masks.end(), file) !=
        import.user_masks.end())
      continue;
    const auto photograph =
        std::find_if(import.photographs.begin(), import.photographs.end(),
                     [&](const Photograph& p) { return IsMaskOf(file, p.name); });
    if (photograph == import.photographs.end())
      strangers.push_back(file.filename().string());
    else
      doubles.push_back(
          file.filename().string() + " (for " + photograph->name + " " +
          import.user_masks[photograph - import.photographs.begin()].filename().string() +
          " is used)");
  }
  if (!doubles.empty())
    stage.Warn("second masks of a photograph were left out: " + JoinNames(doubles) +
               "; keep one mask for each photograph");
  const bool any = std::any_of(import.user_masks.begin(), import.user_masks.end(),
                               [](const fs::path& mask) { return !mask.empty(); });
  const std::string example = import.photographs[0].name + ".png";
  if (!any && !strangers.empty())
    throw InputError("capture: none of the masks in " + import.masks.string() +
                     " has a photograph's name; name that of " + import.photographs[0].name + ": " +
                     example);
  if (!any) stage.Warn("the folder of masks " + import.masks.string() + " has no mask in it");
  if (any && !strangers.empty())
    stage.Warn("masks that belong to no photograph were left out: " + JoinNames(strangers) +
               "; a mask is named like its photograph, as in " + example);
}

Import Open(StageContext& stage, const CaptureOptions& options) {
  Import import;
  import.folder = stage.Input("photos");
  import.groups = ListPhotographs(import.folder);
  for (const PhotographGroup& group : import.groups)
    import.files.insert(import.files.end(), group.files.begin(), group.files.end());
  if (const auto ignored = IgnoredFiles(import.folder, import.groups); !ignored.empty())
    stage.Warn(WithoutOddBytes("files in " + import.folder.filename().string() +
                               " that are no photographs were left out: " + KindsOf(ignored)));
  import.photographs = InspectPhotographs(import.groups);
  RequireEnoughAndDistinct(import.photographs, options.min_images, import.folder.string());
  RequireUsableSizes(import.photographs);
  FitIntoMemory(stage, import);
  import.quarter_turns = QuarterTurns(import.photographs);
  const int longer = std::max(import.photographs[0].width, import.photographs[0].height);
  if (options.max_size > 0 && longer > options.max_size)
    import.factor = static_cast<double>(options.max_size) / longer;
  for (const PhotographGroup& group : import.groups)
    if (const fs::path side = group.folder / "shoot.json"; fs::exists(side))
      import.side_files[group.folder] = shoot::ParseSideFile(ReadFile(side), side.string());
  if (stage.Has("masks"))
    import.masks = stage.Input("masks");
  else if (fs::is_directory(import.folder / "masks"))
    import.masks = import.folder / "masks";
  for (const PhotographGroup& group : import.groups)
    import.backgrounds.push_back(stage.Has("background") ? stage.Input("background")
                                                         : FindBackground(group.folder));
  import.user_masks.resize(import.files.size());
  for (std::size_t i = 0; i < import.files.size(); ++i) {
    const fs::path beside = import.files[i].parent_path() / "masks";
    if (!import.masks.empty())
      import.user_masks[i] = FindMask(import.masks, import.photographs[i].name);
    if (import.user_masks[i].empty() && !stage.Has("masks") && fs::is_directory(beside))
      import.user_masks[i] = FindMask(beside, import.files[i].filename().string());
  }
  RequireMasksOfPhotographs(stage, import);
  return import;
}

/// Whether some photographs, spread over the set, show the calibration board.
bool ShowsBoard(const Import& import, const CaptureOptions& options) {
  constexpr std::size_t kProbes = 8;
  const std::size_t probes = std::min(kProbes, import.files.size());
  std::vector<char> seen(probes, 0);
  ParallelFor(static_cast<std::int64_t>(probes), [&](std::int64_t k) {
    const std::size_t i = static_cast<std::size_t>(k) * import.files.size() / probes;
    try {
      seen[k] = !FindBoard(Load(import, i, import.files[i], 3), options.Board()).empty();
    } catch (const InputError&) {
      // A damaged photograph is reported later, with all the others.
    }
  });
  return std::find(seen.begin(), seen.end(), 1) != seen.end();
}

/// Decodes everything once, which also detects truncated files, and searches the calibration board.
void DecodeAll(StageContext& stage, Import& import, const CaptureOptions& options) {
  const bool with_board = options.board && ShowsBoard(import, options);
  import.small.resize(import.files.size());
  import.board_corners.resize(import.files.size());
  import.boards.resize(import.files.size());
  ForEach(import, stage.progress(), "cannot be used", [&](std::size_t i) {
    const Image8 image = Load(import, i, import.files[i], 3);
    import.small[i] = WorkingImage(image, options.mask_px);
    if (!with_board) return;
    import.board_corners[i] = FindBoard(image, options.Board());
    import.boards[i] = OddsOfBoard(import.small[i], import.board_corners[i],
                                   static_cast<double>(import.small[i].width) / image.width,
                                   options.Board(), options.Masking().odds_limit);
  });
}

/// Segments the groups unless all masks are given: each placement has its own light and its own
/// empty set.
void SegmentAll(StageContext& stage, Import& import, const CaptureOptions& options) {
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
      clean_plate = WorkingImage(ReadImage(import.backgrounds[g], 3), masking.working_px);
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

Image8 MaskOf(const Import& import, std::size_t i, const Image8& image) {
  if (import.user_masks[i].empty()) return RefinedMask(image, import.small_masks[i]);
  Image8 mask = Load(import, i, import.user_masks[i], 1);
  for (std::uint8_t& m : mask.data) m = m > 127 ? 255 : 0;
  return mask;
}

void WritePhotograph(const Import& import, std::size_t i, const Image8& image, const fs::path& to,
                     int quality) {
  const ImageInfo info = shoot::ReadPhotographInfo(import.files[i]);
  const shoot::SideFile* side = SideFileOf(import, i);
  const bool developed =
      IsHeicName(import.files[i]) || IsRawName(import.files[i]) || (side && side->white);
  if (info.orientation == 1 && !import.quarter_turns[i] && import.factor == 1 && !developed) {
    std::error_code error;
    fs::copy_file(import.files[i], to, fs::copy_options::overwrite_existing, error);
    if (error)
      throw DiskError("cannot copy " + import.files[i].string() + " to " + to.string() + ": " +
                      error.message());
    return;
  }
  ExifToWrite exif;
  exif.focal_mm = info.focal_mm.value_or(0);
  exif.focal_35mm = info.focal_35mm.value_or(0);
  exif.model = info.camera_model;
  WriteImage(to, image, quality, &exif);
}

struct Written {
  CapturedImage image;
  Quality quality;
  Image8 cell;
  Preview preview;
};

Written WriteOne(const Import& import, std::size_t i, const fs::path& folder,
                 const CaptureOptions& options) {
  const Image8 image = Load(import, i, import.files[i], 3);
  const Image8 mask = MaskOf(import, i, image);
  Written written;
  CapturedImage& entry = written.image;
  entry.name = import.photographs[i].name;
  entry.width = image.width;
  entry.height = image.height;
  entry.focal_px = import.photographs[i].focal_px * import.factor;
  entry.mask = "masks/" + entry.name + ".png";
  entry.mask_fraction = MaskFraction(mask);
  entry.mask_given = !import.user_masks[i].empty();
  entry.group = import.photographs[i].group;
  entry.place = PlaceOf(import, i);
  entry.board_corners = import.board_corners[i];
  // Sharpness is measured at a size at which any camera in focus is sharp.
  const Image8 grey = WorkingImage(Grey(image), options.sharpness_px),
               grey_mask = WorkingImage(mask, options.sharpness_px);
  written.quality = MeasureQuality(grey, grey_mask);
  entry.sharpness = written.quality.laplacian_variance;
  entry.exposure = written.quality.exposure;
  written.preview = {WorkingImage(Grey(image), kPreview_px), WorkingImage(mask, kPreview_px)};
  written.cell = ContactCell(image, mask, entry.name, kCellWidth);
  WritePhotograph(import, i, image, folder / entry.name, options.jpeg_quality);
  WriteImage(folder / entry.mask, mask);
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
  // for more photographs, all pairs would take too long
  constexpr std::size_t kFew = 16, kMost = 60;
  if (all.size() < kFew)
    stage.Warn("there are only " + std::to_string(all.size()) +
               " photographs; without the printed calibration board a turn needs 24 of them, 15 "
               "degrees apart, unless the figure is rich in texture");
  if (all.size() > kMost || groups > 1) return;
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

int BoardViews(const Import& import) {
  return static_cast<int>(std::count_if(import.board_corners.begin(), import.board_corners.end(),
                                        [](const auto& corners) { return !corners.empty(); }));
}

void ReportBoard(StageContext& stage, const Import& import) {
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

void ReportSet(StageContext& stage, const Import& import, const std::vector<Written>& all) {
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
  Import import = Open(stage, options);
  ReportProgress(stage.progress(), 0.05, "reading photographs");
  DecodeAll(stage, import, options);
  SegmentAll(stage, import, options);
  const fs::path folder = stage.Output("images");
  fs::create_directories(folder / "masks");
  std::vector<Written> written(import.files.size());
  ReportProgress(stage.progress(), 0.7, "writing images and masks");
  ForEach(import, stage.progress(), "cannot be used",
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
    .version = "6",
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
    .memory_gib = 2,
    .common = {"max_size", "min_images", "min_sharpness", "board", "board_page"}};

}  // namespace

int main(int argc, char** argv) {
  return RunStage<CaptureOptions>(
      argc, argv, kSpec, Run,
      {{"print-board",
        "write the printable calibration board (PDF) to this file and stop; see --board_page",
        PrintBoard}});
}
