#include "cleanup/repair/handles.h"

#include <algorithm>
#include <utility>

#include "cleanup/repair/components.h"
#include "cleanup/repair/holes.h"
#include "cleanup/repair/intersections.h"
#include "cleanup/repair/see_through.h"
#include "cleanup/repair/soup.h"
#include "cleanup/repair/topology.h"
#include "core/geometry.h"
#include "core/size_of.h"

namespace keypose::cleanup {
namespace {

constexpr int kTries = 6;  // loops that are tried before a handle is kept
constexpr int kMendingRounds = 4;

// Removes the faces within `rings` rings of the loop and closes the rims.
Mesh CutAlong(const Mesh& closed, const std::vector<int>& loop, int rings) {
  std::vector<char> on_loop(closed.vertex_count(), 0);
  for (const int v : loop) on_loop[v] = 1;
  std::vector<int> faces;
  for (int f = 0; f < closed.face_count(); ++f)
    if (on_loop[closed.faces(f, 0)] || on_loop[closed.faces(f, 1)] || on_loop[closed.faces(f, 2)])
      faces.push_back(f);
  const Mesh open = Without(closed, faces, rings - 1);
  if (open.face_count() == 0) return open;
  Mesh mesh = FillHoles(OrientedManifold(open, 0).mesh, nullptr, 0).mesh;
  OrientOutward(mesh);
  return mesh;
}

// The mesh with fewer handles, or no faces when no cut succeeds. At least `seen` of the handles
// that the lines see through stay.
Mesh WithOneLess(const Mesh& closed, const std::vector<SightLine>& lines, int seen,
                 double* length) {
  const int genus = Genus(closed);
  const int pieces = static_cast<int>(FindPieces(closed).list.size());
  const std::vector<std::vector<int>> loops = HandleLoops(closed);
  const auto good = [&](const Mesh& mesh) {
    return static_cast<int>(FindPieces(mesh).list.size()) <= pieces && Genus(mesh) < genus &&
           (seen == 0 || HandlesSeenThrough(mesh, lines) >= seen);
  };
  // Each handle that must stay adds loops that cannot be cut.
  const int tries = std::min<int>(kTries * (1 + seen), SizeOf(loops));
  for (int i = 0; i < tries; ++i)
    for (const int rings : {1, 2, 3}) {
      int dropped = 0;
      const Mesh mesh = CutAlong(closed, loops[i], rings);
      if (mesh.face_count() == 0) continue;
      *length = LoopLength(closed, loops[i]);
      // Removing a strip can separate a tiny piece, which is dropped here. A larger piece stays,
      // and the piece count then rejects the result.
      const Mesh whole = WithoutBits(mesh, 0.01, &dropped);
      if (!good(whole)) continue;
      if (CheckClosed(whole).closed() && !SelfIntersects(whole)) return whole;
      Mesh mended = WithoutIntersections(whole, kMendingRounds);
      if (mended.face_count() == 0) continue;
      OrientOutward(mended);
      if (!good(mended)) continue;
      if (CheckClosed(mended).closed() && !SelfIntersects(mended)) return mended;
    }
  return {};
}

}  // namespace

HandlesResult WithoutHandles(const Mesh& closed, int genus, const std::vector<SightLine>& lines) {
  HandlesResult result;
  result.mesh = closed;
  const int before = Genus(closed);
  if (before <= genus) return result;
  const int seen = std::min(genus, HandlesSeenThrough(closed, lines));
  while (Genus(result.mesh) > genus) {
    double length = 0;
    Mesh less = WithOneLess(result.mesh, lines, seen, &length);
    if (less.face_count() == 0) break;
    result.mesh = std::move(less);
    result.lengths.push_back(length);
  }
  result.cut = before - Genus(result.mesh);
  return result;
}

}  // namespace keypose::cleanup
