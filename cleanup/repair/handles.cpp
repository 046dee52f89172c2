#include "cleanup/repair/handles.h"

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "cleanup/repair/components.h"
#include "cleanup/repair/handle_loops.h"
#include "cleanup/repair/holes.h"
#include "cleanup/repair/intersections.h"
#include "cleanup/repair/see_through.h"
#include "cleanup/repair/soup.h"
#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"

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

// A loop's places: a cut elsewhere numbers the vertices anew, but does not move them.
using Places = std::vector<std::array<double, 3>>;
Places PlacesOf(const Mesh& mesh, const std::vector<int>& loop) {
  Places places;
  for (const int v : loop)
    places.push_back({mesh.points(v, 0), mesh.points(v, 1), mesh.points(v, 2)});
  std::sort(places.begin(), places.end());
  return places;
}

// The mesh cut along the loop with one handle less; without faces if it cannot be cut so.
// `good` tells whether pieces and handles are as they should be.
template <class Good>
Mesh CutThrough(const Mesh& closed, const std::vector<int>& loop, const Good& good) {
  for (const int rings : {1, 2, 3}) {
    int dropped = 0;
    const Mesh mesh = CutAlong(closed, loop, rings);
    if (mesh.face_count() == 0) continue;
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

// The mesh with fewer handles, or no faces when no cut succeeds. At least `seen` of the handles
// that the lines see through stay. Loops in `uncut` are not tried again; those that fail are added:
// a cut elsewhere does not help them, and a figure of columns has dozens that must stay.
Mesh WithOneLess(const Mesh& closed, const std::vector<SightLine>& lines, int seen,
                 std::set<Places>& uncut, double* length) {
  const int genus = Genus(closed);
  const int pieces = static_cast<int>(FindPieces(closed).list.size());
  const std::vector<std::vector<int>> loops = HandleLoops(closed);
  const auto good = [&](const Mesh& mesh) {
    return static_cast<int>(FindPieces(mesh).list.size()) <= pieces && Genus(mesh) < genus &&
           (seen == 0 || HandlesSeenThrough(mesh, lines) >= seen);
  };
  // Each handle that must stay adds loops that cannot be cut.
  const int tries = std::min<int>(kTries * (1 + seen), SizeOf(loops));
  for (int i = 0; i < tries; ++i) {
    const Places places = PlacesOf(closed, loops[i]);
    if (uncut.contains(places)) continue;
    Mesh less = CutThrough(closed, loops[i], good);
    if (less.face_count() > 0) {
      *length = LoopLength(closed, loops[i]);
      return less;
    }
    uncut.insert(places);
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
  std::set<Places> uncut;
  while (Genus(result.mesh) > genus) {
    double length = 0;
    Mesh less = WithOneLess(result.mesh, lines, seen, uncut, &length);
    if (less.face_count() == 0) break;
    result.mesh = std::move(less);
    result.lengths.push_back(length);
  }
  result.cut = before - Genus(result.mesh);
  return result;
}

}  // namespace keypose::cleanup
