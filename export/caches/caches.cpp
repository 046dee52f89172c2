#include "export/caches/caches.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <utility>

#include "core/values/size_of.h"
#include "export/caches/template_obj.h"

namespace keypose::exporting {
namespace {

constexpr std::size_t kWordBytes = 4;

void AppendWord(std::string& bytes, std::uint32_t word, std::endian order) {
  for (int i = 0; i < 4; ++i) {
    const int byte = order == std::endian::little ? i : 3 - i;
    bytes += static_cast<char>(word >> (8 * byte));
  }
}

void AppendCount(std::string& bytes, int count, std::endian order) {
  AppendWord(bytes, static_cast<std::uint32_t>(count), order);
}

void AppendFloat(std::string& bytes, double value, std::endian order) {
  AppendWord(bytes, std::bit_cast<std::uint32_t>(static_cast<float>(value)), order);
}

float ReadFloat(const std::string& bytes, std::size_t at, std::endian order) {
  std::uint32_t word = 0;
  for (int i = 0; i < 4; ++i) {
    const int byte = order == std::endian::little ? i : 3 - i;
    word |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at + i])) << (8 * byte);
  }
  return std::bit_cast<float>(word);
}

/// Largest distance between these points and the ones in the cache from `at` on.
double ErrorOfSample(const std::string& bytes, std::size_t at, std::endian order,
                     const PointsX3& points) {
  double largest = 0;
  for (Eigen::Index v = 0; v < points.rows(); ++v) {
    Eigen::RowVector3d written;
    for (int c = 0; c < 3; ++c, at += kWordBytes) written[c] = ReadFloat(bytes, at, order);
    largest = std::max(largest, (written - points.row(v)).norm());
  }
  return largest;
}

/// What a cache shows.
struct Samples {
  std::vector<int> frames;    ///< one per sample
  std::vector<int> vertices;  ///< of the frames
};

Samples SamplesOf(const Scene& scene) { return {ShownFrames(scene), VerticesByFaces(scene)}; }

/// A cache file: its header, then the points of each sample.
FormatFiles MakeCache(const Scene& scene, const Samples& samples, std::string header,
                      std::endian order, const std::string& extension, Progress* progress) {
  const std::vector<int>& shown = samples.frames;
  std::string bytes = std::move(header);
  bytes.reserve(bytes.size() + 3 * kWordBytes * shown.size() * samples.vertices.size());
  double error = 0;
  for (std::size_t i = 0; i < shown.size(); ++i) {
    ReportProgress(progress, static_cast<double>(i) / static_cast<double>(shown.size()),
                   "writing the " + extension + " cache");
    const PointsX3 points =
        WithYUp(scene.frames[shown[i]].points(samples.vertices, Eigen::all), scene.z_up);
    const std::size_t at = bytes.size();
    for (Eigen::Index k = 0; k < points.size(); ++k) AppendFloat(bytes, points.data()[k], order);
    error = std::max(error, ErrorOfSample(bytes, at, order, points));
  }
  FormatFiles made;
  made.files = MakeTemplateObj(scene, "cache/" + scene.name, shown[0]);
  made.files.push_back({"cache/" + scene.name + "." + extension, std::move(bytes)});
  made.error_over_diagonal = error / SceneDiagonal(scene);
  return made;
}

}  // namespace

FormatFiles MakePc2(const Scene& scene, Progress* progress) {
  const auto order = std::endian::little;
  const Samples samples = SamplesOf(scene);
  std::string header("POINTCACHE2\0", 12);
  AppendCount(header, 1, order);  // version
  AppendCount(header, SizeOf(samples.vertices), order);
  AppendFloat(header, 0, order);  // first frame
  AppendFloat(header, 1, order);  // frames per sample
  AppendCount(header, SizeOf(samples.frames), order);
  return MakeCache(scene, samples, std::move(header), order, "pc2", progress);
}

FormatFiles MakeMdd(const Scene& scene, Progress* progress) {
  const auto order = std::endian::big;
  const Samples samples = SamplesOf(scene);
  std::string header;
  AppendCount(header, SizeOf(samples.frames), order);
  AppendCount(header, SizeOf(samples.vertices), order);
  for (int i = 0; i < SizeOf(samples.frames); ++i)
    AppendFloat(header, i / scene.playback.fps, order);
  return MakeCache(scene, samples, std::move(header), order, "mdd", progress);
}

}  // namespace keypose::exporting
