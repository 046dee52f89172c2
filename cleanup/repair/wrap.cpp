#include "cleanup/repair/wrap.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>

#include <array>
#include <vector>

#include "cleanup/editing/cgal_convert.h"

namespace keypose::cleanup {

Mesh AlphaWrap(const Mesh& soup, double alpha, double offset) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  using WrapMesh = CGAL::Surface_mesh<Kernel::Point_3>;
  std::vector<Kernel::Point_3> points;
  for (int v = 0; v < soup.vertex_count(); ++v)
    points.emplace_back(soup.points(v, 0), soup.points(v, 1), soup.points(v, 2));
  std::vector<std::array<std::size_t, 3>> faces;
  for (int f = 0; f < soup.face_count(); ++f) {
    faces.push_back({static_cast<std::size_t>(soup.faces(f, 0)),
                     static_cast<std::size_t>(soup.faces(f, 1)),
                     static_cast<std::size_t>(soup.faces(f, 2))});
  }
  WrapMesh wrap;
  CGAL::alpha_wrap_3(points, faces, alpha, offset, wrap);
  return FromSurfaceMesh(wrap);
}

}  // namespace keypose::cleanup
