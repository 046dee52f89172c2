#include <algorithm>
#include <atomic>
#include <cctype>
#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/png_io.h"
#include "core/io/pictures/reduced_image.h"
#include "core/io/project/colmap_io.h"
#include "core/io/text/files.h"
#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "reconstruct/matching/feature_crop.h"
#include "reconstruct/sfm/colmap_programs.h"
#include "reconstruct/sfm/colmap_release.h"

namespace keypose::reconstruct {
namespace fs = std::filesystem;

namespace {

/// Asked once: each question starts the program.
const ColmapRelease& InstalledColmap(StageContext& stage) {
  static const ColmapRelease release = [&] {
    const std::string version = ToolVersion("colmap");
    if (version == "missing") return ColmapRelease{};  // RunTool says what to install
    const ColmapRelease found = ParseColmapRelease(version);
    if (found > kLatestKnownColmap)
      stage.Warn("COLMAP " + std::to_string(found.major) + "." + std::to_string(found.minor) +
                 " is later than the releases that are known here, 3.8 to 4.1; if it refuses an "
                 "option, install one of those");
    return found;
  }();
  return release;
}

/// @param arguments  with the options' names of COLMAP 3.8
std::string Colmap(StageContext& stage, const std::vector<std::string>& arguments) {
  return RunTool(stage, "colmap", ArgumentsFor(InstalledColmap(stage), arguments),
                 {"QT_QPA_PLATFORM=offscreen", "OPENBLAS_NUM_THREADS=1", "OMP_NUM_THREADS=1"});
}

std::string Text(double value) {
  std::ostringstream out;
  out.precision(12);
  out << value;
  return out.str();
}
std::string Text(int value) { return std::to_string(value); }
std::string Text(bool value) { return value ? "1" : "0"; }

/// Pictures of one photograph for feature extraction, each a file in one folder.
using Prepared = std::vector<PlacedPicture>;

/// Binary PGM: grey pixels as they are. COLMAP reads it, and nothing is spent on packing.
void WritePgm(const fs::path& path, const Image8& grey) {
  std::string bytes =
      "P5\n" + std::to_string(grey.width) + " " + std::to_string(grey.height) + "\n255\n";
  bytes.append(grey.data.begin(), grey.data.end());
  WriteFile(path, bytes);
}

/// Where a whole photograph that was reduced to a picture of this size has its pixels.
PicturePlace PlaceOf(const CapturedImage& image, const Image8& picture) {
  return {0, 0, static_cast<double>(image.width) / picture.width,
          static_cast<double>(image.height) / picture.height};
}

/// Whether features adapt to slanted surfaces.
bool Adapts(const SfmOptions& options, const FeatureKind& kind) {
  return options.affine_shape && !kind.on_table && (kind.fine || !kind.whole);
}

/// Leaves out features whose descriptors COLMAP may not have set: their values were another's, and
/// not the same in each run.
/// @param adapted  features adapt to slanted surfaces; all are set then
void LeaveOutUnset(const Image8& picture, bool adapted, PicturePlace& place) {
  if (adapted) return;
  place.width = picture.width;
  place.height = picture.height;
  // The last row of the feature's octave, and what halving cut off, in scales of its lowest layer.
  constexpr double kOctaveEnd = 2;
  place.scales_to_end = kOctaveEnd;
}

/// The whole photograph at `whole_px`; at its own size where that is at most `largest_px`, and
/// COLMAP reduces it.
/// @param adapted  features adapt to slanted surfaces
Prepared PrepareWhole(const ImageSet& set, int i, const fs::path& folder, int whole_px,
                      int largest_px, bool adapted) {
  const CapturedImage& image = set.images[i];
  const std::string file = std::to_string(i) + ".pgm";
  const bool large = std::max(image.width, image.height) > largest_px;
  const Image8 photo = ReadReducedTo(set.ImagePath(i), 1, large ? whole_px : largest_px);
  WritePgm(folder / "images" / file, photo);
  PicturePlace place = PlaceOf(image, photo);
  LeaveOutUnset(photo, adapted, place);
  return {{file, place}};
}

void RequireSameSize(const ImageSet& set, int i) {
  const CapturedImage& image = set.images[i];
  const ImageInfo mask = ReadImageInfo(set.MaskPath(i));
  if (mask.width == image.width && mask.height == image.height) return;
  throw InputError("sfm: mask " + image.mask + " is " + std::to_string(mask.width) + " x " +
                   std::to_string(mask.height) + ", but " + image.name + " is " +
                   std::to_string(image.width) + " x " + std::to_string(image.height) +
                   "; run capture again");
}

/// Adds the crop drawn to twice its height: what lies on a table, seen at a slant, comes closer to
/// how it looks from above, so that turning it is a turn in the picture.
/// Source: Morel and Yu, "ASIFT", SIAM J. Imaging Sciences 2009 (one tilt, along the vertical).
void AddStretched(const ObjectCrop& crop, bool lies_across, const fs::path& folder,
                  Prepared& pictures) {
  constexpr int kStretch = 2;
  const int by_x = lies_across ? kStretch : 1, by_y = lies_across ? 1 : kStretch;
  PlacedPicture stretched = pictures.front();
  stretched.name = "tall_" + stretched.name;
  PicturePlace& place = stretched.place;
  place.x0 *= by_x;
  place.pixels_x /= by_x;
  place.y0 *= by_y;
  place.pixels_y /= by_y;
  place.width *= by_x;
  place.height *= by_y;
  const int width = by_x * crop.image.width, height = by_y * crop.image.height;
  WritePgm(folder / "images" / stretched.name, Resized(crop.image, width, height));
  WriteGreyMaskPng(folder / "masks" / (stretched.name + ".png"),
                   ResizedMask(crop.mask, width, height));
  pictures.push_back(stretched);
}

/// The photograph cropped to its mask; whole where there is none.
Prepared PrepareFigure(const ImageSet& set, int i, const fs::path& folder,
                       const SfmOptions& options, const FeatureKind& kind) {
  const CapturedImage& image = set.images[i];
  const std::string file = std::to_string(i) + ".pgm";
  const Image8 photo = ReadReducedTo(set.ImagePath(i), 1, options.max_image_size);
  PicturePlace place = PlaceOf(image, photo);
  if (image.mask.empty()) {
    WritePgm(folder / "images" / file, photo);
    LeaveOutUnset(photo, Adapts(options, kind), place);
    return {{file, place}};
  }
  RequireSameSize(set, i);
  const Image8 mask = ReadReducedTo(set.MaskPath(i), 1, options.max_image_size);
  const double larger = std::max(place.pixels_x, place.pixels_y);
  const auto margin = static_cast<int>(std::lround(options.mask_margin_px / larger));
  const ObjectCrop crop = CropToObject(photo, mask, margin);
  place.x0 = crop.x0;
  place.y0 = crop.y0;
  WritePgm(folder / "images" / file, crop.image);
  WriteGreyMaskPng(folder / "masks" / (file + ".png"), crop.mask);
  LeaveOutUnset(crop.image, Adapts(options, kind), place);
  Prepared pictures = {{file, place}};
  if (kind.on_table) AddStretched(crop, LiesAcross(image), folder, pictures);
  return pictures;
}

/// The longer side to which whole photographs are reduced before features are found.
int WholeSize(const SfmOptions& options, const FeatureKind& kind) {
  return kind.fine ? options.max_image_size : std::min(options.whole_px, options.max_image_size);
}

/// Features of images [begin, end) into a database in `folder`, by COLMAP on one thread.
/// @return the pictures' names there
std::vector<Prepared> ExtractPart(StageContext& stage, const ImageSet& set, int begin, int end,
                                  const fs::path& folder, const SfmOptions& options,
                                  const FeatureKind& kind) {
  // Other pictures have their sizes already.
  const int limit = kind.whole ? WholeSize(options, kind) : 1 << 20;
  fs::create_directories(folder / "images");
  fs::create_directories(folder / "masks");
  std::vector<Prepared> prepared;
  for (int i = begin; i < end; ++i)
    prepared.push_back(kind.whole ? PrepareWhole(set, i, folder, limit, options.max_image_size,
                                                 Adapts(options, kind))
                                  : PrepareFigure(set, i, folder, options, kind));
  Colmap(stage, {"feature_extractor",
                 "--database_path",
                 folder / "features.db",
                 "--image_path",
                 folder / "images",
                 "--ImageReader.mask_path",
                 folder / "masks",
                 "--ImageReader.camera_model",
                 "SIMPLE_RADIAL",
                 "--SiftExtraction.use_gpu",
                 "0",
                 "--SiftExtraction.num_threads",
                 "1",
                 "--SiftExtraction.max_image_size",
                 Text(limit),
                 "--SiftExtraction.max_num_features",
                 Text(options.max_features),
                 "--SiftExtraction.peak_threshold",
                 Text(options.peak_threshold),
                 "--SiftExtraction.first_octave",
                 kind.fine && !kind.whole ? "-1" : "0",
                 "--SiftExtraction.estimate_affine_shape",
                 Text(Adapts(options, kind)),
                 "--SiftExtraction.domain_size_pooling",
                 Text(options.domain_size_pooling)});
  return prepared;
}

}  // namespace

void ExtractFeatures(StageContext& stage, const ImageSet& set, const SfmFiles& files,
                     const SfmOptions& options, const FeatureKind& kind) {
  const int images = SizeOf(set.images);
  constexpr int per_part = 3;
  const int parts = (images + per_part - 1) / per_part;
  const auto folder = [&](std::int64_t k) {
    return files.scratch / ("features" + std::to_string(k));
  };
  std::vector<std::vector<Prepared>> prepared(static_cast<std::size_t>(parts));
  std::atomic<int> done = 0;
  ParallelFor(parts, [&](std::int64_t k) {
    const int begin = static_cast<int>(k) * per_part, end = std::min(images, begin + per_part);
    prepared[k] = ExtractPart(stage, set, begin, end, folder(k), options, kind);
    done += end - begin;
    ReportProgress(
        stage.progress(), 0.4 * done / images,
        "features of " + std::to_string(done) + " of " + std::to_string(images) + " images");
  });
  ColmapDatabase database(files.database);
  for (int k = 0; k < parts; ++k) {
    {
      const ColmapDatabase part(folder(k) / "features.db");
      for (std::size_t i = 0; i < prepared[k].size(); ++i)
        database.AddFeaturesFrom(part, prepared[k][i], k * per_part + static_cast<int>(i));
    }
    fs::remove_all(folder(k));
  }
}

namespace {

/// All elements of all tracks, by point, in the order of ReadColmapModel's points.
std::vector<TrackElement> ReadTracks(const fs::path& model) {
  // COLMAP's layout: a count, then for each point id, position, colour, error, track length, and
  // (image id, feature) pairs. The points come in the order in which ReadColmapModel reads them.
  const std::string bytes = ReadFile(model / "points3D.bin");
  std::size_t at = 0;
  const auto get = [&]<class T>(T) {
    T value;
    if (at + sizeof(T) > bytes.size()) throw ToolError("COLMAP's points3D.bin is truncated");
    std::memcpy(&value, bytes.data() + at, sizeof(T));
    at += sizeof(T);
    return value;
  };
  std::vector<TrackElement> elements;
  const auto points = get(std::uint64_t{});
  for (std::uint64_t p = 0; p < points; ++p) {
    at += 8 + 3 * 8 + 3 + 8;
    const auto length = get(std::uint64_t{});
    for (std::uint64_t t = 0; t < length; ++t) {
      const int image = static_cast<int>(get(std::uint32_t{})) - 1,
                feature = static_cast<int>(get(std::uint32_t{}));
      elements.push_back({image, feature, static_cast<int>(p)});
    }
  }
  return elements;
}

ColmapModel ReadModel(const fs::path& folder) {
  return {ReadColmapModel(folder), ReadTracks(folder)};
}

}  // namespace

namespace {

/// COLMAP's largest errors, in pixels of ordinary photographs, for those of a database.
std::vector<std::string> LargestErrors(const fs::path& database, const SfmOptions& options) {
  const double pixels = options.PixelsOf(ColmapDatabase(database).LongestSide());
  return {"--Mapper.init_max_error",
          Text(4 * pixels),
          "--Mapper.abs_pose_max_error",
          Text(12 * pixels),
          "--Mapper.filter_max_reproj_error",
          Text(4 * pixels),
          "--Mapper.tri_complete_max_reproj_error",
          Text(4 * pixels),
          "--Mapper.tri_merge_max_reproj_error",
          Text(4 * pixels)};
}

std::vector<std::string> Joined(std::vector<std::string> first,
                                const std::vector<std::string>& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

}  // namespace

std::vector<ColmapModel> MapImages(StageContext& stage, const SfmFiles& files,
                                   const SfmOptions& options) {
  const fs::path folder = files.scratch / (files.database.stem().string() + "_models");
  fs::remove_all(folder);  // of an earlier start
  fs::create_directories(folder);
  try {
    Colmap(
        stage,
        Joined({"mapper", "--database_path", files.database, "--image_path", files.images,
                "--output_path", folder, "--Mapper.num_threads", "1", "--Mapper.min_num_matches",
                Text(options.min_inliers), "--Mapper.init_min_tri_angle", "8",
                "--Mapper.abs_pose_min_num_inliers", "15", "--Mapper.filter_min_tri_angle",
                Text(options.min_triangulation_deg), "--Mapper.tri_min_angle",
                Text(options.min_triangulation_deg),
                // Its adjustments only have to limit drift: ours follow.
                "--Mapper.ba_local_num_images", "5", "--Mapper.ba_local_max_num_iterations", "10",
                "--Mapper.ba_local_max_refinements", "1", "--Mapper.ba_global_images_ratio", "1.5",
                "--Mapper.ba_global_points_ratio", "1.5", "--Mapper.ba_global_max_num_iterations",
                "15", "--Mapper.ba_global_max_refinements", "1"},
               LargestErrors(files.database, options)));
  } catch (const ToolError& error) {
    // COLMAP fails when it finds no initial pair. The photographs cause that; the caller reports
    // it.
    stage.Note(std::string("sfm: mapper: ") + error.what());
  }
  std::vector<fs::path> folders;
  for (const auto& entry : fs::directory_iterator(folder))
    if (fs::exists(entry.path() / "images.bin")) folders.push_back(entry.path());
  std::sort(folders.begin(), folders.end());
  std::vector<ColmapModel> models;
  for (const fs::path& path : folders) models.push_back(ReadModel(path));
  std::stable_sort(models.begin(), models.end(), [](const ColmapModel& a, const ColmapModel& b) {
    return a.scene.views.size() > b.scene.views.size();
  });
  return models;
}

std::vector<Observation> ObservationsOf(const ColmapModel& model, const ImageSet& set,
                                        const std::vector<Features>& features) {
  const Scene& scene = model.scene;
  std::vector<int> view_of(set.images.size(), -1);
  for (std::size_t v = 0; v < scene.views.size(); ++v)
    if (const int i = set.Find(scene.views[v].name); i >= 0) view_of[i] = static_cast<int>(v);
  std::vector<Observation> observations;
  for (const TrackElement& element : model.tracks) {
    const auto image = static_cast<std::size_t>(element.image);
    if (image >= set.images.size() || view_of[image] < 0 || element.feature < 0 ||
        element.feature >= features[image].count())
      throw ToolError("COLMAP's points3D.bin names a feature that is not there");
    observations.push_back(
        {view_of[image], element.point,
         features[image].positions.row(element.feature).transpose().cast<double>()});
  }
  return observations;
}

namespace {

bool SameCamera(const Camera& a, const Camera& b) {
  return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy &&
         a.cx == b.cx && a.cy == b.cy && a.k1 == b.k1 && a.k2 == b.k2 && a.p1 == b.p1 &&
         a.p2 == b.p2;
}

bool OneCamera(const std::vector<View>& views) {
  return std::all_of(views.begin(), views.end(), [&](const View& view) {
    return SameCamera(view.camera, views.front().camera);
  });
}

/// Writes a model without points in COLMAP's text form. Image ids are those of the database, and
/// also the camera where all images share one.
void WriteCameras(const fs::path& folder, const ImageSet& set, const std::vector<View>& views) {
  fs::create_directories(folder);
  std::ostringstream cameras, images;
  cameras.precision(17);
  images.precision(17);
  const bool one_camera = OneCamera(views);
  for (const View& view : views) {
    const int id = set.Find(view.name) + 1;
    if (id == 0) throw InputError("sfm: " + view.name + " is not among the photographs");
    const Camera& c = view.camera;
    const int camera = one_camera ? 1 : id;
    if (!one_camera || &view == &views.front())
      cameras << camera << " OPENCV " << c.width << " " << c.height << " " << c.fx << " " << c.fy
              << " " << c.cx << " " << c.cy << " " << c.k1 << " " << c.k2 << " " << c.p1 << " "
              << c.p2 << "\n";
    const Eigen::Quaterniond& q = view.camera_from_world.rotation;
    const Eigen::Vector3d& t = view.camera_from_world.translation;
    images << id << " " << q.w() << " " << q.x() << " " << q.y() << " " << q.z() << " " << t.x()
           << " " << t.y() << " " << t.z() << " " << camera << " " << view.name << "\n\n";
  }
  WriteFile(folder / "cameras.txt", cameras.str());
  WriteFile(folder / "images.txt", images.str());
  WriteFile(folder / "points3D.txt", "");
}

void Triangulate(StageContext& stage, const SfmFiles& files, const fs::path& input,
                 const fs::path& output, const SfmOptions& options) {
  fs::create_directories(output);
  Colmap(stage, Joined({"point_triangulator",
                        "--database_path",
                        files.database,
                        "--image_path",
                        files.images,
                        "--input_path",
                        input,
                        "--output_path",
                        output,
                        "--clear_points",
                        "1",
                        "--Mapper.min_num_matches",
                        "6",
                        "--Mapper.num_threads",
                        "1",
                        "--Mapper.ba_refine_focal_length",
                        "0",
                        "--Mapper.ba_refine_extra_params",
                        "0",
                        "--Mapper.filter_min_tri_angle",
                        Text(options.min_triangulation_deg),
                        "--Mapper.tri_min_angle",
                        Text(options.min_triangulation_deg)},
                       LargestErrors(files.database, options)));
}

}  // namespace

ColmapModel TriangulateKnown(StageContext& stage, const ImageSet& set, const SfmFiles& files,
                             const std::vector<View>& views, const std::string& name,
                             const SfmOptions& options) {
  const fs::path known = files.scratch / (name + "_known"),
                 model = files.scratch / (name + "_points");
  WriteCameras(known, set, views);
  try {
    Triangulate(stage, files, known, model, options);
  } catch (const ToolError& error) {
    // COLMAP fails when it triangulates no point, for a figure without texture. Its cameras are
    // still valid.
    stage.Note(std::string("sfm: no point could be triangulated: ") + error.what());
    Scene cameras;
    cameras.views = views;
    fs::create_directories(model);
    WriteColmapModel(model, cameras);
    return ReadModel(model);
  }
  if (views.size() == set.images.size() || !OneCamera(views)) return ReadModel(model);
  const fs::path more = files.scratch / (name + "_more");
  fs::create_directories(more);
  try {
    Colmap(stage,
           Joined({"image_registrator", "--database_path", files.database, "--input_path", model,
                   "--output_path", more, "--Mapper.num_threads", "1",
                   "--Mapper.abs_pose_min_num_inliers", "15", "--Mapper.fix_existing_images", "1"},
                  LargestErrors(files.database, options)));
  } catch (const ToolError& error) {
    stage.Note(std::string("sfm: image_registrator: ") + error.what());
    return ReadModel(model);
  }
  const Scene grown = ReadColmapModel(more);
  if (grown.views.size() == views.size()) return ReadModel(model);
  const fs::path grown_known = files.scratch / (name + "_more_known"),
                 grown_model = files.scratch / (name + "_more_points");
  WriteCameras(grown_known, set, grown.views);
  Triangulate(stage, files, grown_known, grown_model, options);
  return ReadModel(grown_model);
}

std::vector<std::pair<std::string, double>> AnalyzeModel(StageContext& stage,
                                                         const fs::path& model) {
  std::istringstream lines(Colmap(stage, {"model_analyzer", "--path", model}));
  std::vector<std::pair<std::string, double>> numbers;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t colon = line.find(": ");
    if (colon == std::string::npos) continue;
    std::string name;
    for (const char c : line.substr(0, colon))
      name += c == ' ' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    std::istringstream value(line.substr(colon + 2));
    double number = 0;
    if (value >> number) numbers.emplace_back(name, number);
  }
  return numbers;
}

}  // namespace keypose::reconstruct
