#include "export/sequences/sequences.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <system_error>

#include "core/io/meshes/mesh_io.h"
#include "core/io/meshes/ply_frames.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::exporting {
namespace {

namespace fs = std::filesystem;

void MakeFolder(const fs::path& folder) {
  std::error_code fault;
  fs::create_directories(folder, fault);
  if (fault || !fs::is_directory(folder))
    throw DiskError("export: cannot make the folder " + folder.string() +
                    (fault ? ": " + fault.message() : ": there is a file of that name"));
}

/// "frame_0012" of `count` files; all names are equally long, so that they sort by number.
std::string NumberedName(int number, int count) {
  const std::size_t digits = std::max<std::size_t>(4, std::to_string(count - 1).size());
  const std::string text = std::to_string(number);
  return "frame_" + std::string(digits - text.size(), '0') + text;
}

void AppendNumber(std::string& text, double value) {
  char digits[32];
  text += ' ';
  text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
}

template <class Rows>
void AppendRows(std::string& text, const char* keyword, const Rows& rows) {
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    text += keyword;
    for (Eigen::Index c = 0; c < rows.cols(); ++c) AppendNumber(text, rows(i, c));
    text += '\n';
  }
}

/// Texture coordinates and faces, which all files share.
std::string SharedLines(const Scene& scene) {
  const Mesh& mesh = scene.frames[0];
  const FaceNet& net = scene.net;
  std::string text;
  if (mesh.has_uvs()) AppendRows(text, "vt", mesh.uvs);
  text += "s 1\n";  // smooth normals
  int corner = 0;
  for (const int size : net.sizes) {
    text += 'f';
    for (const int end = corner + size; corner < end; ++corner) {
      text += ' ' + std::to_string(net.vertices[corner] + 1);  // OBJ counts from 1
      if (!net.uvs.empty()) text += '/' + std::to_string(net.uvs[corner] + 1);
    }
    text += '\n';
  }
  return text;
}

/// Positions of the lines that begin with "v ".
PointsX3 ReadPositions(const std::string& lines, Eigen::Index count) {
  PointsX3 points(count, 3);
  const char* at = lines.data();
  const char* const end = at + lines.size();
  for (Eigen::Index v = 0; v < count; ++v) {
    ++at;  // the keyword
    for (int c = 0; c < 3; ++c) at = std::from_chars(at + 1, end, points(v, c)).ptr;
    ++at;  // the line's end
  }
  return points;
}

double LargestDistance(const PointsX3& a, const PointsX3& b) {
  return std::sqrt((a - b).rowwise().squaredNorm().maxCoeff());
}

std::string MaterialText(const std::string& texture_path) {
  return "newmtl clay\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nmap_Kd " + texture_path + '\n';
}

void FinishSequence(const Scene& scene, const std::vector<int>& shown, WrittenSequence& written) {
  std::set<int> pictures;
  for (const int frame : shown) pictures.insert(scene.clip.picture[frame]);
  written.files = SizeOf(shown);
  written.pictures = SizeOf(pictures);
  const double diagonal = SceneDiagonal(scene);
  if (diagonal > 0) written.error_over_diagonal /= diagonal;
}

}  // namespace

WrittenSequence WriteObjSequence(const Scene& scene, const fs::path& folder,
                                 const std::string& texture_path, Progress* progress) {
  MakeFolder(folder);
  const auto head_with = [](const std::string& material) {
    return "mtllib " + material + "\no character\nusemtl clay\n";
  };
  std::string head = "o character\n";
  if (!texture_path.empty() && scene.frames[0].has_uvs()) {
    WriteFile(folder / "character.mtl", MaterialText(texture_path));
    head = head_with("character.mtl");
  }
  const bool per_frame = !scene.frame_texture_names.empty() && scene.frames[0].has_uvs();
  const std::string shared = SharedLines(scene);
  const std::vector<int> shown = ShownFrames(scene);
  WrittenSequence written;
  std::string positions;
  int picture = -1;
  for (int i = 0; i < SizeOf(shown); ++i) {
    ReportProgress(progress, static_cast<double>(i) / SizeOf(shown), "writing OBJ files");
    if (scene.clip.picture[shown[i]] != picture) {
      picture = scene.clip.picture[shown[i]];
      const PointsX3 points = WithYUp(scene.frames[picture].points, scene.z_up);
      positions.clear();
      AppendRows(positions, "v", points);
      written.error_over_diagonal =
          std::max(written.error_over_diagonal,
                   LargestDistance(ReadPositions(positions, points.rows()), points));
    }
    const std::string name = NumberedName(i, SizeOf(shown));
    if (per_frame) {
      WriteFile(folder / (name + ".mtl"),
                MaterialText("../textures/" + scene.frame_texture_names[shown[i]]));
      head = head_with(name + ".mtl");
    }
    WriteFile(folder / (name + ".obj"), head + positions + shared);
  }
  FinishSequence(scene, shown, written);
  return written;
}

WrittenSequence WritePlySequence(const Scene& scene, const fs::path& folder, Progress* progress) {
  MakeFolder(folder);
  const std::vector<int> shown = ShownFrames(scene);
  PlyFramesForOthers writer(scene.frames[0]);
  WrittenSequence written;
  std::set<int> measured;
  for (int i = 0; i < SizeOf(shown); ++i) {
    ReportProgress(progress, static_cast<double>(i) / SizeOf(shown), "writing PLY files");
    const int picture = scene.clip.picture[shown[i]];
    const PointsX3& points = scene.frames[picture].points;
    const fs::path path = folder / (NumberedName(i, SizeOf(shown)) + ".ply");
    writer.Write(path, points);
    if (!measured.insert(picture).second) continue;
    written.error_over_diagonal =
        std::max(written.error_over_diagonal, LargestDistance(ReadMesh(path).points, points));
  }
  FinishSequence(scene, shown, written);
  return written;
}

}  // namespace keypose::exporting
