#include "studio/project/uploads.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "core/io/pictures/film_kind.h"
#include "core/io/pictures/photograph_files.h"
#include "core/io/project/shot_io.h"
#include "core/io/text/files.h"
#include "core/numbers/sha256.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "pipeline/disk/real_disk.h"
#include "pipeline/graph/pipeline_file.h"
#include "studio/project/films.h"

namespace keypose::studio {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMostFolders = 2;
constexpr const char* kMeshes[] = {".obj", ".ply", ".off", ".stl", ".glb", ".gltf"};
constexpr const char* kTextures[] = {".png", ".jpg", ".jpeg", ".tif", ".tiff"};
constexpr const char* kCalibrations[] = {".yml", ".yaml", ".json", ".txt", ".toml", ".xml", ".csv"};
constexpr const char* kPuppets[] = {".txt", ".json", ".bvh", ".ply", ".obj", ".png",
                                    ".jpg", ".jpeg", ".csv", ".off", ".stl"};

template <std::size_t N>
bool IsOneOf(const std::string& ending, const char* const (&endings)[N]) {
  return std::find(std::begin(endings), std::end(endings), ending) != std::end(endings);
}

/// "cam1/0001.png": folders of plain names and a file.
void RequireUploadName(const std::string& name) {
  const fs::path path(name);
  std::size_t parts = 0;
  for (const fs::path& part : path) {
    ++parts;
    if (!IsOneName(part.string()) || !IsValidUtf8(part.string()) || IsLitterName(part.string()))
      throw UsageError(fmt::format("'{}' cannot be the name of a file", WithoutOddBytes(name)));
  }
  if (parts == 0 || parts > kMostFolders + 1)
    throw UsageError(fmt::format("'{}' lies too deep in its folder", WithoutOddBytes(name)));
}

pipeline::PipelineFile PlanIn(const fs::path& project) {
  const fs::path file = project / "pipeline.yaml";
  if (!fs::is_regular_file(file)) throw UsageError("there is no project in this folder yet");
  return pipeline::ParsePipelineFile(ReadFile(file), "pipeline.yaml");
}

void RequireFilmName(const fs::path& name, const std::string& of) {
  if (name.has_parent_path() ? IsFramePicture(name) : IsFilmName(name)) return;
  throw UsageError(fmt::format(
      "'{}' is no film: {} is a video (.mp4, .mov), or a folder of numbered pictures (.png, .jpg)",
      name.generic_string(), of));
}

void RequireEnding(bool good, const std::string& name, const char* may_be) {
  if (!good) throw UsageError(fmt::format("'{}' is none of {}", name, may_be));
}

/// Where a file goes. @throws UsageError
fs::path PlaceOf(const fs::path& project, const UploadPiece& piece) {
  RequireUploadName(piece.name);
  const fs::path name(piece.name);
  const std::string ending = LowerExtension(name);
  if (piece.place == "shot") {
    const fs::path folder = FilmFolder(project, PlanIn(project), piece.shot);
    RequireFilmName(name, "each camera's");
    return folder / name;
  }
  if (piece.place == "film") {
    RequireFilmName(name, "a film");
    return project / "films" / name;
  }
  if (name.has_parent_path())
    throw UsageError(fmt::format("'{}' is in a folder; send the file alone", piece.name));
  if (piece.place == "calibration") {
    RequireEnding(IsOneOf(ending, kCalibrations), piece.name,
                  "the calibrations that can be read: .yml .json .txt .toml .xml .csv");
    return project / ("calibration" + ending);
  }
  if (piece.place == "scan") {
    RequireEnding(IsOneOf(ending, kMeshes) || IsOneOf(ending, kTextures), piece.name,
                  "meshes (.obj .ply .off .stl .glb) and textures (.png .jpg .tif)");
    return project / "scan" / name;
  }
  if (piece.place == "armature") {
    RequireEnding(IsOneOf(ending, kPuppets), piece.name,
                  "a puppet's files: .txt .json .bvh .ply .obj .png .jpg .csv");
    return project / "armature" / name;
  }
  throw UsageError(fmt::format("files cannot be sent to '{}'", piece.place));
}

/// Films do not fit into the memory at once.
bool SameFile(const fs::path& one, const fs::path& other) {
  if (fs::file_size(one) != fs::file_size(other)) return false;
  std::ifstream a(one, std::ios::binary), b(other, std::ios::binary);
  return std::equal(std::istreambuf_iterator<char>(a), std::istreambuf_iterator<char>(),
                    std::istreambuf_iterator<char>(b));
}

/// A calibration makes room for the one that is sent: as calibration.before.yml.
void PutCalibrationAside(const fs::path& project) {
  for (const std::string& name : pipeline::RealDisk().Children(project))
    if (fs::path(name).stem() == "calibration" && fs::is_regular_file(project / name))
      fs::rename(project / name,
                 project / ("calibration.before" + fs::path(name).extension().string()));
}

/// @throws UsageError  what arrived under a film's name is none
void RequireFilm(const fs::path& part, const fs::path& name) {
  if (!IsFilmName(name)) return;
  std::ifstream in(part, std::ios::binary);
  std::string head(4096, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  if (FilmKindOf(head).empty())
    throw UsageError(
        fmt::format("{} is called a film, but does not hold one", name.filename().string()));
}

void Append(const fs::path& part, const UploadPiece& piece, const std::string& bytes) {
  fs::create_directories(part.parent_path());
  const auto mode = piece.at == 0 ? std::ios::trunc : std::ios::app;
  std::ofstream out(part, std::ios::binary | mode);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (out) return;
  std::error_code ignored;
  fs::remove(part, ignored);
  throw DiskError(fmt::format("cannot write {}; is the disk full?", piece.name));
}

void TakeToPlace(const fs::path& project, const UploadPiece& piece, const fs::path& part,
                 const fs::path& file) {
  RequireFilm(part, file);
  if (fs::exists(file) && SameFile(part, file)) {
    fs::remove(part);
    return;
  }
  if (piece.place == "calibration") PutCalibrationAside(project);
  if (fs::exists(file))
    throw UsageError(
        fmt::format("there is another {} already; send this one under another name", piece.name));
  fs::create_directories(file.parent_path());
  fs::rename(part, file);
}

}  // namespace

Upload TakePiece(const fs::path& project, const UploadPiece& piece, const std::string& bytes) {
  const fs::path file = PlaceOf(project, piece);
  if (!IsWithin(fs::weakly_canonical(file), fs::canonical(project)))
    throw UsageError(
        fmt::format("{} would lie outside of the project; put it there by hand", piece.name));
  const std::string relative = file.lexically_relative(project).generic_string();
  const fs::path part = project / ".keypose/studio/uploads" / (Sha256Of(relative) + ".part");
  const std::uint64_t here = fs::exists(part) ? fs::file_size(part) : 0;
  if (piece.size == 0) throw UsageError(fmt::format("{} is empty", piece.name));
  if (piece.at != 0 && piece.at != here) return {here, ""};
  if (piece.at + bytes.size() > piece.size || bytes.empty())
    throw UsageError(fmt::format("{} is not as long as was said", piece.name));
  Append(part, piece, bytes);
  const std::uint64_t sent = piece.at + bytes.size();
  if (sent < piece.size) return {sent, ""};
  try {
    TakeToPlace(project, piece, part, file);
  } catch (...) {
    std::error_code ignored;
    fs::remove(part, ignored);
    throw;
  }
  return {sent, relative};
}

}  // namespace keypose::studio
