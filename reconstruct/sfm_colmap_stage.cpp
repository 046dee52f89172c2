#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>

#include "core/errors.h"
#include "core/io/colmap_io.h"
#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/parallel.h"
#include "reconstruct/sfm_colmap.h"

namespace keypose::reconstruct {
namespace fs = std::filesystem;

namespace {

constexpr int kVerificationParts = 8;  // fixed: results must not depend on the cores

std::string Colmap(StageContext& stage, const std::vector<std::string>& arguments) {
  return RunTool(stage, "colmap", arguments, {"QT_QPA_PLATFORM=offscreen", "OPENBLAS_NUM_THREADS=1", "OMP_NUM_THREADS=1"});
}

std::string Text(double value) {
  std::ostringstream out;
  out.precision(12);
  out << value;
  return out.str();
}
std::string Text(int value) { return std::to_string(value); }
std::string Text(bool value) { return value ? "1" : "0"; }

/// Grown by `margin` pixels in both axes.
Image8 Grown(const Image8& mask, int margin) {
  Image8 rows(mask.width, mask.height, 1), grown(mask.width, mask.height, 1);
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      std::uint8_t value = 0;
      for (int k = std::max(0, x - margin); k <= std::min(mask.width - 1, x + margin); ++k) value = std::max(value, *mask.at(k, y));
      *rows.at(x, y) = value;
    }
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      std::uint8_t value = 0;
      for (int k = std::max(0, y - margin); k <= std::min(mask.height - 1, y + margin); ++k) value = std::max(value, *rows.at(x, k));
      *grown.at(x, y) = value > 127 ? 255 : 0;
    }
  return grown;
}

}  // namespace

void WriteFeatureMasks(const ImageSet& set, const SfmFiles& files, int margin_px) {
  fs::create_directories(files.masks);
  ParallelFor(static_cast<std::int64_t>(set.images.size()), [&](std::int64_t i) {
    const CapturedImage& image = set.images[static_cast<std::size_t>(i)];
    if (image.mask.empty()) return;
    const Image8 mask = ReadImage(set.MaskPath(static_cast<int>(i)), 1);
    if (mask.width != image.width || mask.height != image.height)
      throw InputError("sfm: mask " + image.mask + " is " + std::to_string(mask.width) + " x " + std::to_string(mask.height) + ", but " +
                       image.name + " is " + std::to_string(image.width) + " x " + std::to_string(image.height) + "; run capture again");
    WriteImage(files.masks / (image.name + ".png"), Grown(mask, margin_px));
  });
}

void ExtractFeatures(StageContext& stage, const ImageSet& set, const SfmFiles& files, const SfmOptions& options) {
  std::string list;
  for (const CapturedImage& image : set.images) list += image.name + "\n";
  const fs::path list_file = files.scratch / "images.txt";
  WriteFile(list_file, list);
  Colmap(stage, {"feature_extractor",
                 "--database_path",
                 files.database,
                 "--image_path",
                 files.images,
                 "--image_list_path",
                 list_file,
                 "--ImageReader.mask_path",
                 files.masks,
                 "--ImageReader.single_camera",
                 "1",
                 "--ImageReader.camera_model",
                 "SIMPLE_RADIAL",
                 "--SiftExtraction.use_gpu",
                 "0",
                 "--SiftExtraction.num_threads",
                 Text(ThreadCount()),
                 "--SiftExtraction.max_image_size",
                 Text(options.max_image_size),
                 "--SiftExtraction.max_num_features",
                 Text(options.max_features),
                 "--SiftExtraction.peak_threshold",
                 Text(options.peak_threshold),
                 "--SiftExtraction.estimate_affine_shape",
                 Text(options.affine_shape),
                 "--SiftExtraction.domain_size_pooling",
                 Text(options.domain_size_pooling)});
}

void VerifyMatches(StageContext& stage, const SfmFiles& files, const std::vector<PairMatches>& matches, const SfmOptions& options) {
  const ImageSet set = ReadImageSet(files.images);
  std::vector<fs::path> parts(kVerificationParts);
  ParallelFor(kVerificationParts, [&](std::int64_t k) {
    std::vector<PairMatches> part;
    for (std::size_t i = static_cast<std::size_t>(k); i < matches.size(); i += kVerificationParts) part.push_back(matches[i]);
    if (part.empty()) return;
    const fs::path database = files.scratch / ("part" + std::to_string(k) + ".db"),
                   list = files.scratch / ("part" + std::to_string(k) + ".txt");
    fs::copy_file(files.database, database);
    ColmapDatabase(database).WriteMatches(part);
    std::string lines;
    for (const PairMatches& pair : part)
      lines += set.images[static_cast<std::size_t>(pair.first)].name + " " + set.images[static_cast<std::size_t>(pair.second)].name + "\n";
    WriteFile(list, lines);
    Colmap(stage,
           {"matches_importer", "--database_path", database, "--match_list_path", list, "--match_type", "pairs", "--SiftMatching.use_gpu",
            "0", "--SiftMatching.num_threads", "1", "--SiftMatching.min_num_inliers", Text(options.min_inliers)});
    parts[static_cast<std::size_t>(k)] = database;
  });
  ColmapDatabase whole(files.database);
  for (const fs::path& part : parts) {
    if (part.empty()) continue;
    whole.AddPairsFrom(part);
    fs::remove(part);
  }
}

std::vector<fs::path> MapImages(StageContext& stage, const SfmFiles& files, const SfmOptions& options) {
  const fs::path folder = files.scratch / "models";
  fs::create_directories(folder);
  try {
    Colmap(stage, {"mapper", "--database_path", files.database, "--image_path", files.images, "--output_path", folder,
                   "--Mapper.num_threads", "1", "--Mapper.min_num_matches", Text(options.min_inliers), "--Mapper.init_min_tri_angle", "8",
                   "--Mapper.abs_pose_min_num_inliers", "15", "--Mapper.filter_min_tri_angle", Text(options.min_triangulation_deg),
                   "--Mapper.tri_min_angle", Text(options.min_triangulation_deg)});
  } catch (const ToolError& error) {
    // COLMAP fails when no two images make a start: that is a fault of the photographs, which the caller words.
    stage.Note(std::string("sfm: mapper: ") + error.what());
  }
  std::vector<std::pair<std::size_t, fs::path>> models;
  for (const auto& entry : fs::directory_iterator(folder))
    if (fs::exists(entry.path() / "images.bin")) models.emplace_back(ReadColmapModel(entry.path()).views.size(), entry.path());
  std::sort(models.begin(), models.end(),
            [](const auto& a, const auto& b) { return a.first != b.first ? a.first > b.first : a.second < b.second; });
  std::vector<fs::path> folders;
  for (auto& model : models) folders.push_back(std::move(model.second));
  return folders;
}

std::vector<Observation> ReadObservations(const fs::path& model, const ImageSet& set, const Scene& scene,
                                          const std::vector<Features>& features) {
  // COLMAP's layout: a count, then for each point id, position, colour, error, track length, and (image id, feature) pairs. The points
  // come in the order in which ReadColmapModel reads them.
  const std::string bytes = ReadFile(model / "points3D.bin");
  std::size_t at = 0;
  const auto get = [&]<class T>(T) {
    T value;
    if (at + sizeof(T) > bytes.size()) throw ToolError("COLMAP's points3D.bin is truncated");
    std::memcpy(&value, bytes.data() + at, sizeof(T));
    at += sizeof(T);
    return value;
  };
  std::vector<int> view_of(set.images.size(), -1);
  for (std::size_t v = 0; v < scene.views.size(); ++v)
    if (const int i = set.Find(scene.views[v].name); i >= 0) view_of[static_cast<std::size_t>(i)] = static_cast<int>(v);
  std::vector<Observation> observations;
  const auto points = get(std::uint64_t{});
  for (std::uint64_t p = 0; p < points; ++p) {
    at += 8 + 3 * 8 + 3 + 8;
    const auto length = get(std::uint64_t{});
    for (std::uint64_t t = 0; t < length; ++t) {
      const std::size_t image = get(std::uint32_t{}) - 1U;
      const auto feature = static_cast<Eigen::Index>(get(std::uint32_t{}));
      if (image >= set.images.size() || view_of[image] < 0 || feature >= features[image].count())
        throw ToolError("COLMAP's points3D.bin names a feature that is not there");
      observations.push_back({view_of[image], static_cast<int>(p), features[image].positions.row(feature).transpose().cast<double>()});
    }
  }
  return observations;
}

std::vector<std::pair<std::string, double>> AnalyzeModel(StageContext& stage, const fs::path& model) {
  std::istringstream lines(Colmap(stage, {"model_analyzer", "--path", model}));
  std::vector<std::pair<std::string, double>> numbers;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t colon = line.find(": ");
    if (colon == std::string::npos) continue;
    std::string name;
    for (const char c : line.substr(0, colon)) name += c == ' ' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    std::istringstream value(line.substr(colon + 2));
    double number = 0;
    if (value >> number) numbers.emplace_back(name, number);
  }
  return numbers;
}

}  // namespace keypose::reconstruct
