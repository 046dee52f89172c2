#include "core/io/meshes/polygon_fan.h"

#include <fmt/format.h>

#include <iterator>

#include "core/values/errors.h"

namespace keypose {

FacesX3 Fan::Take() const {
  FacesX3 faces(std::ssize(triangles_), 3);
  for (std::size_t f = 0; f < triangles_.size(); ++f)
    for (int k = 0; k < 3; ++k) faces(static_cast<Eigen::Index>(f), k) = triangles_[f][k];
  return faces;
}

void Fan::Refuse(double corner) const {
  throw InputError(fmt::format("{}: face {} names vertex {}, but the file has {}", path_.string(),
                               polygons_, corner, vertex_count_));
}

}  // namespace keypose
