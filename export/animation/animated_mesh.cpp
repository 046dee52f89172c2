#include "export/animation/animated_mesh.h"

#include <iterator>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/surfaces/seams.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::exporting {
namespace {

void RequireSameConnectivity(const Mesh& first, const Mesh& frame, const std::string& first_name,
                             const std::string& name) {
  const std::string advice =
      "; all frames of an animation must have the same connectivity: interpolate between meshes "
      "that `register` wrote";
  if (frame.vertex_count() != first.vertex_count() || frame.face_count() != first.face_count()) {
    throw InputError("export: " + name + " has " + std::to_string(frame.vertex_count()) +
                     " vertices and " + std::to_string(frame.face_count()) + " faces, but " +
                     first_name + " has " + std::to_string(first.vertex_count()) + " and " +
                     std::to_string(first.face_count()) + advice);
  }
  for (int f = 0; f < first.face_count(); ++f) {
    if (frame.faces.row(f) != first.faces.row(f))
      throw InputError("export: face " + std::to_string(f) + " of " + name +
                       " joins other vertices than in " + first_name + advice);
  }
}

struct SplitVertex {
  Eigen::Vector2d uv;
  int index;
};

// Corners of one vertex with equal texture coordinates share a split vertex, even if their rows in
// `uvs` differ.
void Split(const Mesh& mesh, AnimatedMesh& out) {
  std::vector<std::vector<SplitVertex>> copies(mesh.vertex_count());
  std::vector<Eigen::Vector2d> uvs;
  out.faces.resize(mesh.face_count(), 3);
  for (int f = 0; f < mesh.face_count(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const int vertex = mesh.faces(f, k);
      const Eigen::Vector2d uv = mesh.has_uvs() ? Eigen::Vector2d(mesh.uvs.row(mesh.uv_faces(f, k)))
                                                : Eigen::Vector2d::Zero();
      int index = -1;
      for (const auto& copy : copies[vertex]) {
        if (copy.uv == uv) index = copy.index;
      }
      if (index < 0) {
        index = SizeOf(uvs);
        copies[vertex].push_back({uv, index});
        uvs.push_back(uv);
        out.source_vertex.push_back(vertex);
      }
      out.faces(f, k) = index;
    }
  }
  if (!mesh.has_uvs()) return;
  out.uvs.resize(uvs.size(), 2);
  for (std::size_t i = 0; i < uvs.size(); ++i) out.uvs.row(i) = uvs[i];
}

// Renderers and glTF require unit normals, even if the faces around a vertex have no area.
PointsX3 UnitNormals(const Mesh& frame, const FacesX3& faces) {
  PointsX3 normals = VertexNormals(frame.points, faces);
  for (Eigen::Index v = 0; v < normals.rows(); ++v) {
    if (normals.row(v).squaredNorm() < 0.5) normals.row(v) = Eigen::RowVector3d::UnitZ();
  }
  return normals;
}

}  // namespace

AnimatedMesh MakeAnimatedMesh(const std::vector<Mesh>& frames,
                              const std::vector<std::string>& names) {
  if (frames.empty()) throw InputError("export: there are no frames; run `interpolate` first");
  for (std::size_t i = 0; i < frames.size(); ++i) {
    RequireUsable(frames[i], names[i]);
    RequireSameConnectivity(frames[0], frames[i], names[0], names[i]);
  }
  AnimatedMesh out;
  Split(frames[0], out);
  // Both sides of a seam that came with the mesh are shaded as one surface.
  const Seams seams = FindSeams(frames[0]);
  const FacesX3 faces = WeldedFaces(frames[0].faces, seams);
  std::vector<int> shaded_as = out.source_vertex;
  if (!seams.empty())
    for (int& v : shaded_as) v = seams.one[v];
  out.points.resize(frames.size());
  out.normals.resize(frames.size());
  ParallelFor(std::ssize(frames), [&](std::int64_t i) {
    out.points[i] = frames[i].points(out.source_vertex, Eigen::all);
    out.normals[i] = UnitNormals(frames[i], faces)(shaded_as, Eigen::all);
  });
  return out;
}

}  // namespace keypose::exporting
