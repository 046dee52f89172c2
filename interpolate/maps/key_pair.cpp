#include "interpolate/maps/key_pair.h"

#include <string>

#include "core/surfaces/mesh_checks.h"
#include "core/values/errors.h"

namespace keypose::interpolation {

void RequireKeys(const PointsX3& v, const PointsX3& u, const FacesX3& faces) {
  if (v.rows() != u.rows())
    throw InputError("interpolate: the keys have " + std::to_string(v.rows()) + " and " +
                     std::to_string(u.rows()) +
                     " vertices; register all poses from one template first");
  Mesh mesh;
  mesh.faces = faces;
  mesh.points = v;
  RequireUsable(mesh, "interpolate: first key");
  mesh.points = u;
  RequireUsable(mesh, "interpolate: second key");
}

}  // namespace keypose::interpolation
