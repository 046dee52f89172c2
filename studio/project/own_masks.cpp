#include "studio/project/own_masks.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/photograph_files.h"
#include "core/io/text/files.h"
#include "core/io/text/yaml_edit.h"
#include "core/numbers/sha256.h"
#include "core/pictures/image_turns.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "pipeline/disk/project_paths.h"
#include "pipeline/disk/real_disk.h"
#include "studio/project/changes.h"

namespace keypose::studio {

namespace fs = std::filesystem;

namespace {

/// Masks that belong to a photograph are named like it: IMG.png, IMG_mask.png, IMG.jpg.png.
bool IsMaskFor(const fs::path& mask, const fs::path& photograph) {
  const std::string stem = mask.stem().string(), own = photograph.stem().string();
  return stem == photograph.string() || stem == own || stem == own + "_mask" ||
         stem == photograph.string() + "_mask";
}

/// The folder that pipeline.yaml names; empty if it names none.
fs::path NamedFolder(Snapshot& snapshot, const std::string& pose) {
  const pipeline::PoseRule* rule = snapshot.file().FindPose(pose);
  const pipeline::Setting* masks = rule ? rule->Given("masks") : nullptr;
  if (masks == nullptr) return {};
  return snapshot.project() / pipeline::OnDisk(pipeline::RealDisk(), snapshot.project(),
                                               pipeline::WithHome(masks->text));
}

/// The pose's folder of masks. The first mask makes one, and names it in pipeline.yaml.
fs::path MaskFolder(Snapshot& snapshot, const std::string& pose) {
  if (const fs::path named = NamedFolder(snapshot, pose); !named.empty()) return named;
  pipeline::RealDisk disk;
  const fs::path folder = snapshot.project() / "masks" / pose;
  // Masks beside the photographs would no longer be found once the project names a folder.
  const fs::path beside = snapshot.PhotoFolder(pose) / "masks";
  for (const std::string& file : disk.FilesBelow(beside)) disk.Copy(beside / file, folder / file);
  fs::create_directories(folder);
  const fs::path whole = snapshot.project() / "pipeline.yaml";
  const std::string text = ReadFile(whole), revision = RevisionOf(whole);
  WritePipelineFile(snapshot.project(), Edited([&] {
                      return WithPoseSetting(snapshot, text, pose, {"masks"},
                                             YamlScalar("masks/" + pose));
                    }),
                    revision);
  return folder;
}

/// @throws UsageError
void RequireInProject(Snapshot& snapshot, const std::string& pose, const fs::path& folder) {
  if (!IsWithin(fs::weakly_canonical(folder), fs::canonical(snapshot.project())))
    throw UsageError(fmt::format("the masks of '{}' are outside of the project", pose));
}

/// The size that a mask must have: that of the original, upright.
ImageInfo InfoOf(const Originals& originals, const std::string& pose, const std::string& name) {
  const fs::path file = originals.FileOf(name);
  if (file.empty()) throw UsageError(fmt::format("pose '{}' has no photograph '{}'", pose, name));
  return OriginalInfo(file);
}

Image8 ReadMaskBytes(const fs::path& writing, const std::string& png) {
  constexpr char kPngMark[] = "\x89PNG";
  if (png.compare(0, 4, kPngMark) != 0) throw InputError("a mask must be a PNG");
  WriteFile(writing, png);
  return ReadImage(writing, 1);
}

/// Only black and white, of the given size. Capture turns portraits among landscapes, and shows
/// them so to the page.
Image8 AsMask(Image8 image, int width, int height) {
  if ((image.width > image.height) != (width > height)) image = TurnedOver(QuarterTurned(image));
  const double ratio = 1.0 * image.width * height / (1.0 * image.height * width);
  if (ratio < 0.99 || ratio > 1.01)
    throw InputError(fmt::format("the mask has {} x {} pixels, the photograph {} x {}", image.width,
                                 image.height, width, height));
  Image8 mask =
      image.width == width && image.height == height ? image : Resized(image, width, height);
  for (auto& value : mask.data) value = value >= 128 ? 255 : 0;
  return mask;
}

/// @throws UsageError  no SHA-256 of a file
void RequireHash(const std::string& hash) {
  const bool fine = hash.size() == 64 && hash.find_first_not_of("0123456789abcdef") == hash.npos;
  if (!fine) throw UsageError("a photograph is named by the 64 digits of its SHA-256");
}

/// Out of the way, under a name that is free: nothing that a person painted is deleted.
void SetAside(const fs::path& file) {
  fs::path free = file.string() + ".old";
  for (int i = 2; fs::exists(free); ++i) free = fmt::format("{}.old{}", file.string(), i);
  fs::rename(file, free);
}

/// Masks of other names: the pipeline reads one of each photograph.
void SetOthersAside(const fs::path& folder, const std::string& photograph,
                    const fs::path& written) {
  for (const fs::path file : pipeline::RealDisk().Children(folder))
    if (folder / file != written && IsPhotographName(file) && IsMaskFor(file, photograph))
      SetAside(folder / file);
}

}  // namespace

OwnMasks::OwnMasks(Snapshot& snapshot, const std::string& pose)
    : snapshot_(snapshot), originals_(snapshot, pose), folder_(NamedFolder(snapshot, pose)) {
  if (folder_.empty()) return;
  for (const fs::path file : pipeline::RealDisk().Children(folder_))
    if (IsPhotographName(file) && fs::is_regular_file(folder_ / file)) files_.push_back(file);
  notes_ = ReadPaintedMasks(folder_);
}

fs::path OwnMasks::FileOf(const std::string& name) const {
  if (!IsOneName(name)) return {};
  for (const fs::path& file : files_)
    if (IsMaskFor(file, WrittenName(name))) return folder_ / file;
  return {};
}

bool OwnMasks::IsOfAnother(const std::string& name) const {
  const fs::path mask = FileOf(name);
  if (mask.empty() || !notes_.contains(mask.filename().string())) return false;
  const std::string photograph = originals_.HashOf(name);
  if (photograph.empty()) return false;
  const std::string hash = snapshot_.opened_project().workshop().hasher.OfFile(mask);
  return keypose::IsOfAnother(notes_, mask.filename().string(), {hash, photograph});
}

fs::path OwnMasks::InForce(const std::string& name) const {
  return IsOfAnother(name) ? fs::path() : FileOf(name);
}

fs::path SaveMask(Snapshot& snapshot, const std::string& pose, const std::string& name,
                  const std::string& png, const std::string& over) {
  RequirePhotograph(snapshot, pose, name);
  if (!over.empty()) RequireHash(over);
  const OwnMasks own(snapshot, pose);
  const ImageInfo original = InfoOf(own.originals(), pose, name);
  const fs::path scratch = snapshot.project() / ".keypose/studio";
  fs::create_directories(scratch);
  const fs::path writing =
      scratch / ("mask_" + RevisionOf(snapshot.project() / "pipeline.yaml") + ".png");
  const Image8 mask = AsMask(ReadMaskBytes(writing, png), original.width, original.height);
  WriteImage(writing, mask);
  const fs::path folder = MaskFolder(snapshot, pose);
  RequireInProject(snapshot, pose, folder);
  if (own.IsOfAnother(name)) SetAside(own.FileOf(name));
  const fs::path file = folder / (WrittenName(name) + ".png");
  PaintedMasks notes = ReadPaintedMasks(folder);
  notes[file.filename().string()] = {Sha256Of(ReadFile(writing)),
                                     over.empty() ? own.originals().HashOf(name) : over};
  // The note before the mask: until that is there, it speaks of no mask, and harms none.
  WritePaintedMasks(folder, notes);
  pipeline::RealDisk(scratch).Copy(writing, file);
  fs::remove(writing);
  SetOthersAside(folder, WrittenName(name), file);
  return file;
}

void DecideMasks(Snapshot& snapshot, const std::string& pose, const std::vector<std::string>& names,
                 bool hold) {
  if (!snapshot.HasPose(pose)) throw UsageError(fmt::format("there is no pose '{}'", pose));
  const fs::path folder = NamedFolder(snapshot, pose);
  const OwnMasks own(snapshot, pose);
  for (const std::string& name : names) {
    if (!own.IsOfAnother(name))
      throw UsageError(fmt::format("no mask of '{}' was painted over another photograph", name));
    const ImageInfo now = InfoOf(own.originals(), pose, name),
                    then = ReadImageInfo(own.FileOf(name));
    if (hold && (now.width != then.width || now.height != then.height))
      throw UsageError(fmt::format(
          "the mask of {} has {} x {} pixels, and the photograph {} x {} now: paint it again", name,
          then.width, then.height, now.width, now.height));
  }
  if (names.empty()) return;
  RequireInProject(snapshot, pose, folder);
  PaintedMasks notes = ReadPaintedMasks(folder);
  for (const std::string& name : names) {
    const fs::path mask = own.FileOf(name);
    if (hold) {
      notes[mask.filename().string()].photograph = own.originals().HashOf(name);
    } else {
      notes.erase(mask.filename().string());
      SetAside(mask);
    }
  }
  WritePaintedMasks(folder, notes);
}

}  // namespace keypose::studio
