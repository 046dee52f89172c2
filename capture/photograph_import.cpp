#include "capture/photograph_import.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "capture/pictures/working_image.h"
#include "capture/segmentation/masking.h"
#include "capture/shoot/develop/photograph.h"
#include "capture/shoot/develop/white_balance.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_levels.h"
#include "core/io/pictures/painted_masks.h"
#include "core/io/pictures/photograph_files.h"
#include "core/io/pictures/png_io.h"
#include "core/io/pictures/reduced_image.h"
#include "core/io/text/files.h"
#include "core/numbers/parallel.h"
#include "core/numbers/sha256.h"
#include "core/pictures/image_turns.h"
#include "core/values/errors.h"
#include "core/values/left_out.h"
#include "core/values/memory.h"

namespace keypose::capture {
namespace {

/// What `keypose shoot` has noted of a folder; null for photographs of another origin.
const shoot::SideFile* SideFileIn(const PhotographImport& import, const fs::path& folder) {
  const auto side = import.side_files.find(folder);
  return side == import.side_files.end() ? nullptr : &side->second;
}

const shoot::SideFile* SideFileOf(const PhotographImport& import, std::size_t i) {
  return SideFileIn(import, import.files[i].parent_path());
}

/// The picture, with the white balance of its session's grey card if there is one.
Image8 ReadBalanced(const fs::path& file, const shoot::SideFile* side) {
  Image8 image = shoot::ReadPhotograph(file);
  return side && side->white ? shoot::WithGains(image, side->white->gains) : image;
}

/// Whether the file has more than 8 bits a channel that are kept: RAW files are developed to 8.
bool IsDeep(const fs::path& file) { return !IsRawName(file) && StoredLevelsOf(file).bits > 8; }

/// Whether the photograph's file is no picture that later stages read.
bool IsDeveloped(const PhotographImport& import, std::size_t i) {
  const shoot::SideFile* side = SideFileOf(import, i);
  return IsHeicName(import.files[i]) || IsRawName(import.files[i]) || (side && side->white);
}

/// Each photograph in progress takes many times the pixels that it is looked at with (measured: 90
/// bytes each, most for the board and the mask), and a large one some times its own (measured: 7
/// bytes each, where it is encoded). If there is not enough memory for one per core, fewer are
/// processed at a time; the result is the same.
void FitIntoMemory(StageContext& stage, const PhotographImport& import) {
  constexpr std::int64_t kBytesADetail = 90, kBytesAPixel = 9, kBytesADeepPixel = 18;
  std::size_t largest = 0;
  const auto pixels = [&](std::size_t i) {
    return std::int64_t{import.photographs[i].width} * import.photographs[i].height;
  };
  for (std::size_t i = 1; i < import.photographs.size(); ++i)
    if (pixels(i) > pixels(largest)) largest = i;
  const Photograph& photograph = import.photographs[largest];
  const std::int64_t eighths = EighthsFor(photograph.width, photograph.height, kDetail_px);
  const std::int64_t each = IsDeep(import.files[largest]) ? kBytesADeepPixel : kBytesAPixel;
  const std::int64_t need = kBytesADetail * pixels(largest) * eighths * eighths / 64 +
                            (eighths < 8 ? each * pixels(largest) : 0);
  RequireMemory(need, "capture: photograph " + photograph.name + " (" +
                          std::to_string(photograph.width) + " x " +
                          std::to_string(photograph.height) + " pixels)");
  const std::int64_t at_once = FreeMemory() / std::max<std::int64_t>(1, need);
  if (at_once >= ThreadCount()) return;
  SetThreadCount(static_cast<int>(std::max<std::int64_t>(1, at_once)));
  stage.Note("capture: memory for " + std::to_string(ThreadCount()) + " photographs at a time");
}

/// Files of a folder of masks whose names are those of no picture that is read.
std::vector<fs::path> OtherFilesIn(const fs::path& folder) {
  std::vector<fs::path> others;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file() && !IsPhotographName(entry.path()) && !IsLitterName(entry.path()))
      others.push_back(entry.path());
  return others;
}

/// Reports user masks with other names, so that none is ignored silently.
void RequireMasksOfPhotographs(StageContext& stage, const PhotographImport& import) {
  if (import.masks.empty()) return;
  std::vector<std::string> strangers, doubles;
  for (const fs::path& file : ImagesIn(import.masks)) {
    if (std::find(import.user_masks.begin(), import.user_masks.end(), file) !=
        import.user_masks.end())
      continue;
    if (std::any_of(import.left_out.begin(), import.left_out.end(),
                    [&](const std::string& name) { return IsMaskOf(file, name); }))
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
  // Masks that the studio painted had a photograph once: they are not misnamed.
  const PaintedMasks painted = ReadPaintedMasks(import.masks);
  const bool misnamed =
      std::any_of(strangers.begin(), strangers.end(),
                  [&](const std::string& name) { return !painted.contains(name); });
  const bool any = std::any_of(import.user_masks.begin(), import.user_masks.end(),
                               [](const fs::path& mask) { return !mask.empty(); });
  const std::string example = import.photographs[0].name + ".png";
  if (!any && misnamed)
    throw InputError("capture: none of the masks in " + import.masks.string() +
                     " has a photograph's name; name that of " + import.photographs[0].name + ": " +
                     example);
  const std::vector<fs::path> unread = OtherFilesIn(import.masks);
  const std::string cure = CureFor(unread);
  const std::string unread_text =
      WithoutOddBytes(import.masks.string() + " holds " + KindsOf(unread) +
                      ", which are no masks that are read; " + cure);
  if (!any && strangers.empty() && !cure.empty()) throw InputError("capture: " + unread_text);
  if (!cure.empty()) stage.Warn(unread_text);
  if (!any && strangers.empty() && import.left_out.empty())
    stage.Warn("the folder of masks " + import.masks.string() + " has no mask in it");
  if (!strangers.empty())
    stage.Warn("masks that belong to no photograph were left out: " + JoinNames(strangers) +
               "; a mask is named like its photograph, as in " + example);
}

void FindMasksAndPlates(StageContext& stage, PhotographImport& import) {
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
}

/// Different sizes are different lenses: one with few photographs cannot be solved for. In a pose
/// that need not be a scan, lenses are known.
void TellOfSizes(StageContext& stage, const PhotographImport& import, bool scan) {
  constexpr std::size_t kFewest = 3;  // as reconstruct/sfm/set_lenses.h
  if (import.sizes.size() < 2) return;
  const std::string text = DifferentSizes(import.photographs, import.sizes);
  if (!scan)
    stage.Warn(text +
               "; each takes the lens of the template's photographs of its size, else of its "
               "shape: all must be of the template's cameras");
  else if (import.sizes.back().photographs.size() >= kFewest)
    stage.Note("capture: " + text + "; each size is taken for a lens of its own");
  else
    stage.Warn(text +
               "; each size is taken for a lens of its own, and fewer than three photographs do "
               "not tell what their lens is: leave out what was cropped or sent in a smaller size, "
               "or give the camera's own files");
}

/// Masks that were painted over other photographs of these names are not used: their outlines would
/// be wrong for what was shot again.
void LeaveOutMasksOfAnother(StageContext& stage, PhotographImport* import) {
  std::map<fs::path, PaintedMasks> notes;  // by folder
  std::vector<std::string> names;
  for (std::size_t i = 0; i < import->files.size(); ++i) {
    fs::path& mask = import->user_masks[i];
    if (mask.empty()) continue;
    const auto [of, is_new] = notes.try_emplace(mask.parent_path());
    if (is_new) of->second = ReadPaintedMasks(mask.parent_path());
    const std::string name = mask.filename().string();
    if (!of->second.contains(name)) continue;
    const PaintedMask now{Sha256Of(ReadFile(mask)), Sha256Of(ReadFile(import->files[i]))};
    if (!IsOfAnother(of->second, name, now)) continue;
    names.push_back(import->photographs[i].name);
    mask.clear();
  }
  if (names.empty()) return;
  stage.ReportJson("masks_of_others", nlohmann::json(names).dump());
  stage.Warn(
      "these photographs were shot again since their masks were painted, and the masks are "
      "not used: " +
      JoinNames(names) +
      "; paint them again, or say on the studio's page Poses that they still hold (or "
      "delete " +
      kPaintedNotes + " beside the masks)");
}

}  // namespace

namespace {

/// Takes out what a person leaves out. Names of none are told: they may be misspelt.
void LeaveOut(StageContext& stage, const std::string& text, PhotographImport* import) {
  const std::vector<std::string> names = ParseLeftOut(text);
  std::vector<std::string>& out = import->left_out;
  std::vector<std::string> of_none = names;
  for (PhotographGroup& group : import->groups)
    std::erase_if(group.files, [&](const fs::path& file) {
      const fs::path below = file.lexically_relative(import->folder);
      const std::string written =
          (below.has_parent_path() ? group.name + "_" : "") + WrittenName(file);
      const auto means = [&](const std::string& name) {
        return MeansPhotograph(name, below, written);
      };
      const bool leave = std::any_of(names.begin(), names.end(), means);
      if (leave) out.push_back(written);
      std::erase_if(of_none, means);
      return leave;
    });
  std::erase_if(import->groups, [](const PhotographGroup& group) { return group.files.empty(); });
  if (!of_none.empty())
    stage.Warn("leave_out names photographs that are not there: " + JoinNames(of_none));
  stage.ReportJson("left_out", nlohmann::json(out).dump());
  if (import->groups.empty())
    throw InputError("capture: all photographs in " + import->folder.string() +
                     " are left out; take some back");
  if (!out.empty()) stage.Note("left out, as leave_out says: " + JoinNames(out));
}

}  // namespace

PhotographImport OpenPhotographs(StageContext& stage, const CaptureOptions& options) {
  PhotographImport import;
  import.folder = stage.Input("photos");
  import.groups = ListPhotographs(import.folder);
  if (const auto ignored = IgnoredFiles(import.folder, import.groups); !ignored.empty())
    stage.Warn(WithoutOddBytes("files in " + import.folder.filename().string() +
                               " that are no photographs were left out: " + KindsOf(ignored)));
  if (!options.leave_out.empty()) LeaveOut(stage, options.leave_out, &import);
  for (const PhotographGroup& group : import.groups)
    import.files.insert(import.files.end(), group.files.begin(), group.files.end());
  import.photographs = InspectPhotographs(import.groups);
  RequireEnoughAndDistinct(import.photographs, options.min_images, import.folder.string());
  RequireUsableSizes(import.photographs);
  FitIntoMemory(stage, import);
  import.quarter_turns = QuarterTurns(import.photographs);
  import.sizes = GroupedBySize(import.photographs, import.quarter_turns);
  TellOfSizes(stage, import, IsOfAScan(options.min_images));
  for (const Photograph& photograph : import.photographs) {
    const int longer = std::max(photograph.width, photograph.height);
    const bool large = options.max_size > 0 && longer > options.max_size;
    import.factors.push_back(large ? static_cast<double>(options.max_size) / longer : 1);
  }
  for (const PhotographGroup& group : import.groups)
    if (const fs::path side = group.folder / kShootNotes; fs::exists(side))
      import.side_files[group.folder] = shoot::ParseSideFile(ReadFile(side), side.string());
  FindMasksAndPlates(stage, import);
  RequireMasksOfPhotographs(stage, import);
  LeaveOutMasksOfAnother(stage, &import);
  return import;
}

std::optional<TurntablePlace> PlaceOf(const PhotographImport& import, std::size_t i) {
  const shoot::SideFile* side = SideFileOf(import, i);
  if (!side) return std::nullopt;
  const auto shot = shoot::ShotNamed(side->plan, import.files[i].stem().string());
  if (!shot) return std::nullopt;
  return TurntablePlace{shot->ring, shoot::AngleOf(side->plan, *shot),
                        shoot::TiltOf(side->plan, *shot), shot->flip};
}

Image8 LoadPlate(const PhotographImport& import, std::size_t group) {
  return ReadBalanced(import.backgrounds[group], SideFileIn(import, import.groups[group].folder));
}

Size WrittenSize(const PhotographImport& import, std::size_t i) {
  const Photograph& photograph = import.photographs[i];
  Size size{photograph.width, photograph.height};
  if (import.quarter_turns[i]) std::swap(size.width, size.height);
  if (import.factors[i] == 1) return size;
  const auto part = [&](int side) {
    return std::max(1, static_cast<int>(std::lround(side * import.factors[i])));
  };
  return {part(size.width), part(size.height)};
}

Image8 LoadUpright(const PhotographImport& import, std::size_t i) {
  Image8 image = ReadBalanced(import.files[i], SideFileOf(import, i));
  if (import.quarter_turns[i]) image = QuarterTurned(image);
  const Size size = WrittenSize(import, i);
  return import.factors[i] == 1 ? image : Resized(image, size.width, size.height);
}

int DetailEighths(const PhotographImport& import, std::size_t i) {
  const Size size = WrittenSize(import, i);
  return EighthsFor(size.width, size.height, kDetail_px);
}

Image8 LoadReduced(const PhotographImport& import, std::size_t i, int eighths) {
  const Photograph& photograph = import.photographs[i];
  // A quarter turn would put a last row that is cut short to the other side.
  const bool turns = import.quarter_turns[i] &&
                     (photograph.width * eighths % 8 != 0 || photograph.height * eighths % 8 != 0);
  if (eighths == 8 || import.factors[i] != 1 || turns || IsDeveloped(import, i))
    return Reduced(LoadUpright(import, i), eighths);
  Image8 image = ReadReduced(import.files[i], 3, eighths);
  return import.quarter_turns[i] ? QuarterTurned(image) : image;
}

void ForEachPhotograph(const PhotographImport& import, Progress* progress, const std::string& what,
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

namespace {

void CopyPhotograph(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::copy_file(from, to, fs::copy_options::overwrite_existing, error);
  if (error)
    throw DiskError("cannot copy " + from.string() + " to " + to.string() + ": " + error.message());
}

/// As LoadUpright, with the levels of a file of more than 8 bits; empty for others.
Image16 LoadUprightDeep(const PhotographImport& import, std::size_t i) {
  const fs::path& file = import.files[i];
  if (!IsDeep(file)) return {};
  Image16 image = ReadAsStored(file).sixteen;
  const shoot::SideFile* side = SideFileOf(import, i);
  if (side && side->white) image = shoot::WithGains(image, side->white->gains);
  if (import.quarter_turns[i]) image = Oriented(std::move(image), 6);
  const Size size = WrittenSize(import, i);
  return import.factors[i] == 1 ? image : Resized(image, size.width, size.height);
}

/// What the picture is looked at with: the nearest levels of 8 bits, which later stages read from
/// the file written.
Image8 InEightBits(const Image16& deep) {
  Image8 image(deep.width, deep.height, deep.channels);
  std::transform(deep.data.begin(), deep.data.end(), image.data.begin(), [](std::uint16_t level) {
    return static_cast<std::uint8_t>((level + 128) / 257);
  });
  return image;
}

/// Writes the pixels as they are looked at or, where the file has more than 8 bits, with all of
/// them. Decodes the file once.
/// @return what it is looked at with, at full size
Image8 EncodePhotograph(const PhotographImport& import, std::size_t i, const fs::path& to,
                        int quality, const ExifToWrite& exif) {
  const Image16 deep = LoadUprightDeep(import, i);
  if (deep.empty()) {
    Image8 image = LoadUpright(import, i);
    WriteImage(to, image, quality, &exif);
    return image;
  }
  WriteImage(to, deep, quality, &exif);
  return InEightBits(deep);
}

/// Writes the photograph: its file where nothing changed, else its pixels with its EXIF data.
/// @return what it is looked at with
Image8 WritePhotograph(const PhotographImport& import, std::size_t i, const fs::path& to,
                       int quality) {
  const ImageInfo info = shoot::ReadPhotographInfo(import.files[i]);
  if (info.orientation == 1 && !import.quarter_turns[i] && import.factors[i] == 1 &&
      !IsDeveloped(import, i)) {
    CopyPhotograph(import.files[i], to);
    return LoadReduced(import, i, DetailEighths(import, i));
  }
  ExifToWrite exif;
  exif.focal_mm = info.focal_mm.value_or(0);
  exif.focal_35mm = info.focal_35mm.value_or(0);
  exif.model = info.camera_model;
  return Reduced(EncodePhotograph(import, i, to, quality, exif), DetailEighths(import, i));
}

}  // namespace

MaskedPhotograph WriteMasked(const PhotographImport& import, std::size_t i, Image8 own,
                             const fs::path& to, const fs::path& mask_to, int quality) {
  const int eighths = DetailEighths(import, i);
  MaskedPhotograph masked;
  masked.size = WrittenSize(import, i);
  masked.detail = WritePhotograph(import, i, to, quality);
  if (own.empty()) {
    // What a person marked may have several parts.
    const bool said = !import.strokes[i].empty();
    masked.detail_mask =
        (said ? RefinedRegions : RefinedMask)(masked.detail, import.small_masks[i], nullptr);
    if (eighths < 8)
      masked.mask =
          EnlargedMask(masked.detail_mask, eighths, masked.size.width, masked.size.height);
  } else {
    masked.detail_mask = Reduced(own, eighths);
    if (eighths < 8) masked.mask = std::move(own);
  }
  WriteGreyMaskPng(mask_to, masked.mask.empty() ? masked.detail_mask : masked.mask);
  return masked;
}

}  // namespace keypose::capture
