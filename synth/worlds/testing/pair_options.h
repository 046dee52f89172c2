// Small pairs of clay.
#pragma once

#include <cstdint>
#include <string>

#include "core/surfaces/geometry.h"
#include "synth/worlds/clay_pair.h"

namespace keypose::synth {

inline ClayPairOptions Options(double bend_deg, std::uint64_t seed = 0,
                               const std::string& shape = "tentacle") {
  ClayPairOptions options;
  options.shape.bend_deg = bend_deg;
  options.shape.seed = seed;
  options.shape.shape = shape;
  options.vertices = 600;
  return options;
}

inline double MeanEdge(const Mesh& mesh) {
  double sum = 0;
  const auto edges = UndirectedEdges(mesh.faces);
  for (const auto& [a, b] : edges) sum += (mesh.points.row(a) - mesh.points.row(b)).norm();
  return sum / static_cast<double>(edges.size());
}

}  // namespace keypose::synth
