#include "export/caches/testing/polygon_scene.h"

#include <cmath>
#include <numbers>
#include <sstream>
#include <stdexcept>

#include "core/io/meshes/polygon_mesh.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"
#include "export/caches/testing/run_reader.h"

namespace keypose::exporting {
namespace {

/// Gathers the lines of an OBJ.
class ObjLines {
 public:
  void Vertex(double x, double y, double z) {
    text_ << "v " << x << ' ' << y << ' ' << z << '\n';
    ++vertices_;
  }

  /// @param corners  vertices from 0
  void Face(const std::vector<int>& corners) {
    const int count = static_cast<int>(corners.size());
    for (int k = 0; k < count; ++k)
      text_ << "vt " << 0.02 + 0.03 * faces_ + 0.002 * k << ' ' << 0.1 + 0.1 * k << '\n';
    uvs_ += count;
    text_ << 'f';
    for (int k = 0; k < count; ++k) {
      if (faces_ % 2 == 0)
        text_ << ' ' << corners[k] + 1 << '/' << uvs_ - count + k + 1;
      else
        text_ << ' ' << corners[k] - vertices_ << '/' << k - count;
    }
    text_ << '\n';
    ++faces_;
  }

  std::string Text() const { return text_.str(); }

 private:
  std::ostringstream text_;
  int vertices_ = 0, uvs_ = 0, faces_ = 0;
};

/// Rings of 6 vertices at three heights are 0 to 17; 18 lies on an edge of the upper wall.
void AddLantern(ObjLines& obj) {
  for (int ring = 0; ring < 3; ++ring)
    for (int side = 0; side < 6; ++side) {
      const double turn = std::numbers::pi / 3 * side, r = ring == 1 ? 1.3 : 1;
      obj.Vertex(r * std::cos(turn), r * std::sin(turn), ring);
    }
  obj.Vertex(1.25, 0, 1.5);
  obj.Face({5, 4, 3, 2, 1, 0});
  for (int side = 0; side < 6; ++side) {
    const int next = (side + 1) % 6;
    obj.Face({side, next, 6 + next, 6 + side});
    if (side > 0 && side < 5) obj.Face({6 + side, 6 + next, 12 + next, 12 + side});
  }
  obj.Face({6, 7, 13, 18});
  obj.Face({18, 13, 12});
  obj.Face({11, 6, 18, 12, 17});
  obj.Face({12, 13, 14, 15, 16, 17});
}

/// Above the lantern: vertices 19 to 25 below, 26 to 32 above.
void AddArrow(ObjLines& obj) {
  constexpr double kArrow[7][2] = {{1.5, 0},     {0, 1},    {0, 0.3}, {-1.5, 0.3},
                                   {-1.5, -0.3}, {0, -0.3}, {0, -1}};
  for (const double z : {3.0, 3.4})
    for (const auto& [x, y] : kArrow) obj.Vertex(x, y, z);
  obj.Face({24, 23, 22, 21, 20, 19, 25});
  obj.Face({29, 30, 31, 32, 26, 27, 28});
  for (int k = 0; k < 7; ++k) {
    const int next = (k + 1) % 7;
    obj.Face({19 + k, 19 + next, 26 + next, 26 + k});
  }
}

}  // namespace

std::string LanternObj() {
  ObjLines obj;
  AddLantern(obj);
  AddArrow(obj);
  obj.Vertex(0, 0, 2.5);
  return obj.Text();
}

NamedFaces FacesOfObj(const std::string& text) {
  NamedFaces faces;
  std::vector<double> uvs;
  int vertices = 0;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string key;
    words >> key;
    vertices += key == "v";
    for (double number = 0; key == "vt" && words >> number;) uvs.push_back(number);
    if (key != "f") continue;
    faces.sizes.push_back(0);
    for (std::string corner; words >> corner; ++faces.sizes.back()) {
      const int vertex = std::stoi(corner);
      faces.vertices.push_back(vertex > 0 ? vertex - 1 : vertex + vertices);
      if (uvs.empty()) continue;
      const int uv = std::stoi(corner.substr(corner.find('/') + 1));
      const std::size_t at = 2 * (uv > 0 ? uv - 1 : uv + uvs.size() / 2);
      faces.uvs.insert(faces.uvs.end(), {uvs[at], uvs[at + 1]});
    }
  }
  return faces;
}

namespace {

std::vector<double> NumbersAfter(const std::string& output, const std::string& name) {
  const auto begin = output.find(name) + name.size();
  std::istringstream list(output.substr(begin, output.find(';', begin) - begin));
  std::vector<double> numbers;
  for (std::string number; std::getline(list, number, ',');) numbers.push_back(std::stod(number));
  return numbers;
}

}  // namespace

BlenderFaces ReadInBlender(const std::string& path) {
  const ReaderResult read =
      RunReader({"blender", "-b", "--factory-startup", "--python-exit-code", "1", "--python",
                 SourceFolder() + "/export/caches/testing/count_faces.py", "--", path});
  if (read.exit_code != 0) throw std::runtime_error(read.output);
  const auto count = [&](const char* name) {
    return static_cast<int>(FigureOf(read.output, name));
  };
  BlenderFaces found{count("faces"),
                     count("faces_3"),
                     count("faces_4"),
                     count("faces_5"),
                     count("faces_6"),
                     count("faces_7"),
                     {},
                     {}};
  for (const double vertex : NumbersAfter(read.output, "corners:"))
    found.vertices.push_back(static_cast<int>(vertex));
  found.uvs = NumbersAfter(read.output, "uvs:");
  return found;
}

Scene LanternScene() {
  const TestingFolder folder;
  WriteFile(folder.path() / "lantern.obj", LanternObj());
  const PolygonMesh read = ReadPolygonMesh(folder.path() / "lantern.obj");
  Scene scene;
  for (const double lean : {0.0, 0.3, 0.5}) {
    Mesh frame = read.mesh;
    frame.points.col(0) += lean * frame.points.col(2);
    scene.frames.push_back(frame);
    scene.frame_names.push_back("frame_000" + std::to_string(scene.frames.size() - 1));
  }
  scene.net = NetOf(read.mesh, read.polygons);
  scene.split = MakeAnimatedMesh(scene.frames, scene.frame_names);
  scene.clip = MakeClip(scene.split.points, {}, false);
  scene.playback = {10, 0, "none"};
  return scene;
}

}  // namespace keypose::exporting
