#include "export/caches/template_obj.h"

#include <algorithm>
#include <charconv>
#include <utility>

#include "core/values/size_of.h"

namespace keypose::exporting {
namespace {

void AppendFloat(std::string& text, double value) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, static_cast<float>(value)).ptr;
  text += ' ';
  text.append(digits, end);
}

template <class Rows>
void AppendRows(std::string& text, const std::string& keyword, const Rows& rows) {
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    text += keyword;
    for (Eigen::Index c = 0; c < rows.cols(); ++c) AppendFloat(text, rows(i, c));
    text += '\n';
  }
}

/// @param place  per vertex of the mesh: its place in the file, from 0
void AppendFaces(std::string& text, const FaceNet& net, const std::vector<int>& place) {
  int corner = 0;
  for (const int size : net.sizes) {
    text += 'f';
    for (const int end = corner + size; corner < end; ++corner) {
      text += ' ' + std::to_string(place[net.vertices[corner]] + 1);  // OBJ counts from 1
      if (!net.uvs.empty()) text += '/' + std::to_string(net.uvs[corner] + 1);
    }
    text += '\n';
  }
}

/// Names end at a blank or a line's end in OBJ files.
std::string OneWord(std::string name) {
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return c <= ' '; }, '_');
  return name;
}

}  // namespace

std::vector<int> VerticesByFaces(const Scene& scene) {
  const Mesh& mesh = scene.frames[0];
  std::vector<char> seen(mesh.vertex_count(), 0);
  std::vector<int> vertices;
  for (const int vertex : scene.net.vertices)
    if (!std::exchange(seen[vertex], 1)) vertices.push_back(vertex);
  return vertices;
}

std::vector<FormatFile> MakeTemplateObj(const Scene& scene, const std::string& path, int frame) {
  const Mesh& mesh = scene.frames[0];  // faces and texture coordinates are those of the first frame
  const std::string material = path.substr(path.rfind('/') + 1) + ".mtl";
  std::string obj = "mtllib " + material + "\no " + OneWord(scene.name) + '\n';
  const std::vector<int> vertices = VerticesByFaces(scene);
  std::vector<int> place(mesh.vertex_count(), -1);
  for (int i = 0; i < SizeOf(vertices); ++i) place[vertices[i]] = i;
  AppendRows(obj, "v", WithYUp(scene.frames[frame].points(vertices, Eigen::all), scene.z_up));
  if (mesh.has_uvs()) AppendRows(obj, "vt", mesh.uvs);
  obj += "usemtl clay\ns 1\n";  // one group with smooth normals
  AppendFaces(obj, scene.net, place);
  std::string mtl = "newmtl clay\nKa 1 1 1\nKd 0.8 0.8 0.8\nKs 0 0 0\n";
  if (mesh.has_uvs() && !scene.textures.empty())
    mtl = "newmtl clay\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nmap_Kd ../textures/" +
          FirstTextureFile(scene) + '\n';
  return {{path + ".obj", obj}, {path + ".mtl", mtl}};
}

}  // namespace keypose::exporting
