// keypose-capture: a folder of photographs to checked images with masks.
#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "capture/board_print.h"
#include "capture/capture_options.h"
#include "capture/contact_sheet.h"
#include "capture/masking.h"
#include "capture/photographs.h"
#include "capture/quality.h"
#include "core/errors.h"
#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/io/image_set.h"
#include "core/parallel.h"
#include "core/stage/stage.h"

namespace {
namespace fs = std::filesystem;
using namespace keypose;
using namespace keypose::capture;

constexpr int kCellWidth = 240;

/// The set while it is imported.
struct Import {
  fs::path folder, masks, background;  // masks, background: empty when the user gave none
  std::vector<fs::path> files;
  std::vector<Photograph> photographs;
  std::vector<char> quarter_turns;
  double factor = 1;          // size written over size read
  std::vector<Image8> small;  // working images
  std::vector<Image8> small_masks;
  std::vector<fs::path> user_masks;
};

Image8 QuarterTurned(const Image8& image) {
  Image8 turned(image.height, image.width, image.channels);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) std::copy_n(image.at(x, y), image.channels, turned.at(image.height - 1 - y, x));
  return turned;
}

/// Pixels as they will be written: upright, of one size.
Image8 Load(const Import& import, std::size_t i, const fs::path& file, int channels) {
  Image8 image = ReadImage(file, channels);
  const Photograph& photograph = import.photographs[i];
  if (image.width != photograph.width || image.height != photograph.height)
    throw InputError("capture: mask " + file.string() + " is " + std::to_string(image.width) + " x " + std::to_string(image.height) +
                     ", but " + photograph.name + " is " + std::to_string(photograph.width) + " x " + std::to_string(photograph.height) +
                     "; make the mask at the photograph's size");
  if (import.quarter_turns[i]) image = QuarterTurned(image);
  if (import.factor == 1) return image;
  return Resized(image, std::max(1, static_cast<int>(std::lround(image.width * import.factor))),
                 std::max(1, static_cast<int>(std::lround(image.height * import.factor))));
}

/// Calls body(i) for all photographs at once and gathers what is wrong with them.
void ForEach(const Import& import, Progress* progress, const std::string& what, const std::function<void(std::size_t)>& body) {
  std::vector<std::string> faults(import.files.size());
  ParallelFor(static_cast<std::int64_t>(import.files.size()), [&](std::int64_t i) {
    if (progress && progress->cancelled()) throw Cancelled();
    try {
      body(static_cast<std::size_t>(i));
    } catch (const InputError& error) {
      faults[static_cast<std::size_t>(i)] = error.what();
    }
  });
  std::erase(faults, "");
  if (faults.size() == 1) throw InputError(faults.front());
  if (!faults.empty()) throw InputError("capture: " + std::to_string(faults.size()) + " files " + what + ":\n  " + JoinNames(faults, 200));
}

Import Open(StageContext& stage, const CaptureOptions& options) {
  Import import;
  import.folder = stage.Input("photos");
  import.files = ListPhotographs(import.folder);
  import.photographs = InspectPhotographs(import.files);
  RequireEnoughAndDistinct(import.photographs, options.min_images, import.folder.string());
  import.quarter_turns = QuarterTurns(import.photographs);
  const int longer = std::max(import.photographs[0].width, import.photographs[0].height);
  if (options.max_size > 0 && longer > options.max_size) import.factor = static_cast<double>(options.max_size) / longer;
  if (stage.Has("masks"))
    import.masks = stage.Input("masks");
  else if (fs::is_directory(import.folder / "masks"))
    import.masks = import.folder / "masks";
  import.background = stage.Has("background") ? stage.Input("background") : FindBackground(import.folder);
  import.user_masks.resize(import.files.size());
  if (!import.masks.empty())
    for (std::size_t i = 0; i < import.files.size(); ++i) import.user_masks[i] = FindMask(import.masks, import.photographs[i].name);
  return import;
}

/// Decodes everything once, which also finds truncated files, and segments the set unless all masks are given.
void SegmentAll(StageContext& stage, Import& import, const CaptureOptions& options) {
  const MaskOptions masking = options.Masking();
  import.small.resize(import.files.size());
  ForEach(import, stage.progress(), "cannot be used",
          [&](std::size_t i) { import.small[i] = WorkingImage(Load(import, i, import.files[i], 3), masking.working_px); });
  import.small_masks.resize(import.files.size());
  if (std::none_of(import.user_masks.begin(), import.user_masks.end(), [](const fs::path& mask) { return mask.empty(); })) return;
  Image8 plate;
  if (!import.background.empty()) plate = WorkingImage(ReadImage(import.background, 3), masking.working_px);
  SubProgress progress(stage.progress(), 0.2, 0.7);
  import.small_masks = SegmentSet(import.small, plate, masking, &progress);
}

Image8 MaskOf(const Import& import, std::size_t i, const Image8& image) {
  if (import.user_masks[i].empty()) return RefinedMask(image, import.small_masks[i]);
  Image8 mask = Load(import, i, import.user_masks[i], 1);
  for (std::uint8_t& m : mask.data) m = m > 127 ? 255 : 0;
  return mask;
}

void WritePhotograph(const Import& import, std::size_t i, const Image8& image, const fs::path& to, int quality) {
  const ImageInfo info = ReadImageInfo(import.files[i]);
  if (info.orientation == 1 && !import.quarter_turns[i] && import.factor == 1) {
    std::error_code error;
    fs::copy_file(import.files[i], to, fs::copy_options::overwrite_existing, error);
    if (error) throw DiskError("cannot copy " + import.files[i].string() + " to " + to.string() + ": " + error.message());
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
};

Written WriteOne(const Import& import, std::size_t i, const fs::path& folder, const CaptureOptions& options) {
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
  // Sharpness is judged at a size at which any camera that is in focus is sharp.
  const Image8 grey = WorkingImage(Grey(image), options.sharpness_px), grey_mask = WorkingImage(mask, options.sharpness_px);
  written.quality = MeasureQuality(grey, grey_mask);
  entry.sharpness = written.quality.laplacian_variance;
  entry.exposure = written.quality.exposure;
  written.cell = ContactCell(image, mask, entry.name, kCellWidth);
  WritePhotograph(import, i, image, folder / entry.name, options.jpeg_quality);
  WriteImage(folder / entry.mask, mask);
  return written;
}

std::vector<std::string> NamesWhere(const std::vector<Written>& all, const std::function<bool(const Written&)>& condition) {
  std::vector<std::string> names;
  for (const Written& written : all)
    if (condition(written)) names.push_back(written.image.name);
  return names;
}

/// A few bad photographs are numbers in the report; a set of them is an error.
void RequireFitSet(StageContext& stage, const std::vector<Written>& all, const CaptureOptions& options) {
  const auto blurred = NamesWhere(all, [&](const Written& w) { return w.quality.crispness < options.min_sharpness; });
  const auto black = NamesWhere(all, [&](const Written& w) { return w.image.mask_fraction < options.min_mask; });
  const auto limit = static_cast<std::size_t>(options.max_bad_share * static_cast<double>(all.size()));
  stage.ReportJson("blurred", nlohmann::json(blurred).dump());
  stage.ReportJson("empty_masks", nlohmann::json(black).dump());
  if (black.size() > limit)
    throw InputError("capture: the masks of " + std::to_string(black.size()) + " of " + std::to_string(all.size()) +
                     " photographs are black (no object found): " + JoinNames(black) +
                     "; give a photograph of the empty set as --background, or masks (white where the object is) as --masks");
  if (blurred.size() > limit)
    throw InputError("capture: " + std::to_string(blurred.size()) + " of " + std::to_string(all.size()) +
                     " photographs are blurred: " + JoinNames(blurred) +
                     "; use a tripod, a smaller aperture and fixed focus and shoot them again, or lower --min_sharpness (now " +
                     nlohmann::json(options.min_sharpness).dump() + ")");
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
  stage.Report("images", static_cast<int>(all.size()));
  stage.Report("width", all.front().image.width);
  stage.Report("height", all.front().image.height);
  stage.Report("camera_model", import.photographs.front().camera_model);
  stage.Report("focal_known", MedianFocalPx(import.photographs) > 0);
  stage.Report("focal_px", MedianFocalPx(import.photographs) * import.factor);
  stage.Report("focal_spread", FocalSpread(import.photographs));
  stage.Report("turned", static_cast<int>(std::count(import.quarter_turns.begin(), import.quarter_turns.end(), 1)));
  stage.Report("user_masks", static_cast<int>(std::count_if(import.user_masks.begin(), import.user_masks.end(),
                                                            [](const auto& m) { return !m.empty(); })));
  stage.Report("background_plate", !import.background.empty());
  stage.Report("mean_sharpness", sharpness);
  stage.Report("mean_exposure", exposure);
  stage.Report("mean_clipped", clipped);
  stage.Report("mean_mask_fraction", fraction);
  stage.ReportJson("photographs", each.dump());
}

void Run(StageContext& stage, const CaptureOptions& options) {
  Import import = Open(stage, options);
  Step(stage.progress(), 0.05, "reading photographs");
  SegmentAll(stage, import, options);
  const fs::path folder = stage.Output("images");
  fs::create_directories(folder / "masks");
  std::vector<Written> written(import.files.size());
  Step(stage.progress(), 0.7, "writing images and masks");
  ForEach(import, stage.progress(), "cannot be used", [&](std::size_t i) { written[i] = WriteOne(import, i, folder, options); });
  ReportSet(stage, import, written);
  RequireFitSet(stage, written, options);
  ImageSet set;
  set.folder = folder;
  set.camera_model = import.photographs.front().camera_model;
  std::vector<Image8> cells;
  for (Written& w : written) {
    set.images.push_back(std::move(w.image));
    cells.push_back(std::move(w.cell));
  }
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
    .version = "1",
    .summary = "Imports and checks photographs of one pose and masks the object in each.",
    .inputs = {{.name = "photos", .kind = "folder", .help = "photographs of one pose: JPEG, PNG or TIFF", .file = ""},
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
    .outputs = {{.name = "images", .kind = "folder", .help = "photographs, masks/, capture.json, contact_sheet.jpg", .file = "images"}},
    .tools = {},
    .cores = 0,
    .memory_gib = 2};

}  // namespace

int main(int argc, char** argv) {
  return RunStage<CaptureOptions>(argc, argv, kSpec, Run,
                                  {{"print-board", "write the printable plate (PDF) to this file and stop; see --board_page", PrintBoard}});
}
