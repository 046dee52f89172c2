#include "cleanup/cleanup.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <stdexcept>

#include "cleanup/components.h"
#include "cleanup/holes.h"
#include "cleanup/intersections.h"
#include "cleanup/measure.h"
#include "cleanup/remesh.h"
#include "cleanup/soup.h"
#include "cleanup/wrap.h"
#include "core/errors.h"
#include "core/geometry.h"

namespace keypose::cleanup {
namespace {

constexpr double kWeld = 1e-7;    // of the diagonal
constexpr double kTouch = 0.005;  // of the diagonal: pieces this near belong together
constexpr int kWorkingFaces = 5;  // times the wanted faces: repair works on no more than that
constexpr int kIntersectionRounds = 7;
constexpr double kCountTolerance = 0.02;
constexpr double kTangle = 0.02;   // share of intersecting faces beyond which local repair is hopeless, and slow
constexpr int kTangleFaces = 300;  // that many are always tried

// Everything between input and result happens in a frame where the diagonal is 1, so that no tolerance depends on the unit.
struct Frame {
  Eigen::RowVector3d center;
  double diagonal;
};

Mesh Normalized(const Mesh& mesh, const Frame& frame) {
  Mesh out;
  out.points = (mesh.points.rowwise() - frame.center) / frame.diagonal;
  out.faces = mesh.faces;
  return out;
}

bool Acceptable(const Mesh& mesh) { return mesh.face_count() > 0 && CheckClosed(mesh).closed() && !SelfIntersects(mesh); }

class Ladder {
 public:
  Ladder(const Mesh& surface, const CleanupOptions& options, Progress* progress, CleanupResult& result)
      : input_(surface), options_(options), progress_(progress), result_(result) {}

  /// The finished mesh in the normalised frame.
  Mesh Climb();
  /// What the result is to be compared with: the input without dropped pieces.
  const Mesh& kept() const { return kept_; }

 private:
  std::optional<Mesh> Try(const char* rung, const std::function<std::optional<Mesh>()>& step);
  void Weld();
  void Fill();
  std::optional<Mesh> Wrap(double alpha, double offset_share, bool project);
  std::optional<Mesh> WrapRungs();
  std::optional<Mesh> Finish(const Mesh& base);
  std::optional<Mesh> AtWantedSize(const Mesh& base, bool uniform);
  std::optional<Mesh> Mended(const Mesh& mesh);
  bool GoodSize(int faces) const { return std::abs(faces - options_.faces) <= kCountTolerance * options_.faces; }

  const Mesh& input_;
  const CleanupOptions& options_;
  Progress* progress_;
  CleanupResult& result_;
  Mesh kept_, filled_;
  std::string last_fault_;
};

// CGAL reports a broken precondition as std::logic_error; that rung has failed then, not the whole.
std::optional<Mesh> Ladder::Try(const char* rung, const std::function<std::optional<Mesh>()>& step) {
  try {
    std::optional<Mesh> mesh = step();
    if (mesh) result_.rung = rung;
    return mesh;
  } catch (const std::logic_error& error) {
    last_fault_ = std::string(rung) + ": " + error.what();
    return std::nullopt;
  }
}

void Ladder::Weld() {
  SoupResult soup = OrientedManifold(input_, kWeld);
  result_.merged_vertices = soup.merged_vertices;
  // Stitching closes the cuts that a fin left, but only once the fin is gone; it also joins pieces, so bits are counted on both sides of
  // it.
  kept_ = Stitched(WithoutBits(Stitched(soup.mesh), options_.min_component, &result_.components_removed));
  if (options_.keep_components == 1) kept_ = WithTouchingPieces(kept_, kTouch, &result_.components_removed);
}

void Ladder::Fill() {
  Mesh working = kept_;
  const double limit = static_cast<double>(kWorkingFaces) * options_.faces;
  if (working.face_count() > limit) working = Decimated(working, static_cast<int>(limit), false);
  working = Stitched(WithoutSlivers(working, 1e-3));
  HolesResult holes = FillHoles(working, progress_);
  result_.holes_filled = holes.filled;
  result_.largest_hole_over_diag = holes.largest_over_diag;
  filled_ = std::move(holes.mesh);
  OrientOutward(filled_);
  IntersectingFaces(filled_, &result_.self_intersections_before);
}

// Local repair of a closed mesh; nothing when it does not help.
std::optional<Mesh> Ladder::Mended(const Mesh& mesh) {
  if (Acceptable(mesh)) return mesh;
  if (!CheckClosed(mesh).finite) return std::nullopt;
  if (static_cast<double>(IntersectingFaces(mesh).size()) > std::max<double>(kTangleFaces, kTangle * mesh.face_count()))
    return std::nullopt;
  Mesh mended = WithoutIntersections(mesh, kIntersectionRounds);
  if (mended.face_count() > 0 && CheckClosed(mended).zero_area_faces > 0) mended = WithoutSlivers(mended, 1e-3);
  if (mended.face_count() == 0) return std::nullopt;
  OrientOutward(mended);
  // Cutting out a crossing can cut a neck through.
  mended = LargestPieces(mended, options_.keep_components, &result_.components_removed);
  if (Acceptable(mended)) return mended;
  return std::nullopt;
}

std::optional<Mesh> Ladder::AtWantedSize(const Mesh& base, bool uniform) {
  Mesh mesh = base;
  if (uniform) {
    int wanted = static_cast<int>(1.1 * options_.faces);
    mesh = base.face_count() > 2.5 * options_.faces ? Decimated(base, static_cast<int>(2.5 * options_.faces), false) : base;
    const Mesh start = mesh;
    for (int attempt = 0; attempt < 3; ++attempt) {
      mesh = UniformlyRemeshed(start, wanted, 4);
      if (mesh.face_count() >= options_.faces) break;
      wanted = static_cast<int>(1.05 * wanted * options_.faces / mesh.face_count());
    }
  } else if (base.face_count() < options_.faces) {
    mesh = UniformlyRemeshed(base, 2 * options_.faces, 4);
  }
  if (mesh.face_count() > options_.faces) mesh = Decimated(mesh, options_.faces, uniform);
  if (!GoodSize(mesh.face_count())) return std::nullopt;
  mesh = LargestPieces(mesh, options_.keep_components, &result_.components_removed);
  return Mended(mesh);
}

std::optional<Mesh> Ladder::Finish(const Mesh& base) {
  const Mesh kept = LargestPieces(base, options_.keep_components, &result_.components_removed);
  const bool fits = kept.face_count() <= (1 + kCountTolerance) * options_.faces && !options_.refine;
  if (fits || GoodSize(kept.face_count())) return kept;
  const bool uniform = options_.remesh == "uniform";
  Step(progress_, 0.75, "remeshing");
  if (std::optional<Mesh> mesh = AtWantedSize(kept, uniform)) return mesh;
  return AtWantedSize(kept, !uniform);
}

std::optional<Mesh> Ladder::Wrap(double alpha, double offset_share, bool project) {
  Step(progress_, 0.5, "wrapping");
  const double offset = alpha * offset_share;
  Mesh wrap = LargestPieces(AlphaWrap(filled_, alpha, offset), options_.keep_components, &result_.components_removed);
  if (project) wrap = ProjectedBack(wrap, filled_, 3 * offset);
  if (!Acceptable(wrap)) return std::nullopt;
  return Finish(wrap);
}

// Thin sheets get walls that lie closer together than an edge is long, and remeshing such walls makes them cross; then thicker ones are
// tried.
std::optional<Mesh> Ladder::WrapRungs() {
  const double area = SurfaceArea(filled_.points, filled_.faces);
  const double automatic = std::clamp(std::sqrt(2 * area / options_.faces), 1.0 / 250, 1.0 / 30);
  const double alpha = options_.wrap_alpha > 0 ? options_.wrap_alpha : automatic;
  if (auto mesh = Try("R4 wrap", [&] { return Wrap(alpha, 1.0 / 30, true); })) return mesh;
  if (auto mesh = Try("R4 thick wrap", [&] { return Wrap(alpha, 1.0 / 3, false); })) return mesh;
  return Try("R4 coarse wrap", [&] { return Wrap(2 * alpha, 1.0 / 2, false); });
}

Mesh Ladder::Climb() {
  Step(progress_, 0.02, "checking");
  kept_ = input_;
  Weld();
  Step(progress_, 0.15, "welded");
  if (auto mesh = Try("R0 weld", [&]() -> std::optional<Mesh> {
        Mesh turned = kept_;
        OrientOutward(turned);
        const bool apart = options_.keep_components == 1 && FindPieces(turned).list.size() > 1;
        if (apart || !Acceptable(turned)) return std::nullopt;
        return Finish(turned);
      }))
    return *mesh;
  try {
    Fill();
  } catch (const std::logic_error& error) {  // CGAL met a case it does not take; the wrap takes everything
    last_fault_ = std::string("R2 fill: ") + error.what();
    filled_ = kept_;
  }
  Step(progress_, 0.4, "holes filled");
  // Pieces that belong together but are not joined: only the wrap makes one surface of them.
  const bool apart = options_.keep_components == 1 && FindPieces(filled_).list.size() > 1;
  if (apart) last_fault_ = "pieces that touch or cross can only be joined by the wrap, or kept apart with --keep_components 0";
  if (auto mesh = Try("R2 fill", [&]() -> std::optional<Mesh> {
        if (apart || !Acceptable(filled_)) return std::nullopt;
        return Finish(filled_);
      }))
    return *mesh;
  if (auto mesh = Try("R3 intersections", [&]() -> std::optional<Mesh> {
        if (apart) return std::nullopt;
        const std::optional<Mesh> mended = Mended(filled_);
        return mended ? Finish(*mended) : std::nullopt;
      }))
    return *mesh;
  if (options_.wrap) {
    if (auto mesh = WrapRungs()) return *mesh;
  }
  throw QualityError("cleanup: no rung of the repair ladder gave a closed surface without self-intersections" +
                     (last_fault_.empty() ? std::string() : " (" + last_fault_ + ")") +
                     "; look at the surface, or try other values of --faces and --wrap_alpha");
}

bool KeptAsIs(const Mesh& surface, const Mesh& normalized, const CleanupOptions& options) {
  if (surface.face_count() > (1 + kCountTolerance) * options.faces) return false;
  if (options.refine && surface.face_count() < (1 - kCountTolerance) * options.faces) return false;
  const ClosedReport report = CheckClosed(surface);
  if (!report.closed() || (options.keep_components > 0 && report.components > options.keep_components)) return false;
  return !SelfIntersects(normalized);
}

}  // namespace

void CleanupOptions::Describe(OptionVisitor& visit) {
  visit("faces", faces,
        {.help = "wanted number of faces; surfaces with more are remeshed to it within 2 %", .unit = "faces", .min = 100, .max = 5000000});
  visit("refine", refine, {.help = "also remesh surfaces that have fewer faces than wanted", .unit = ""});
  visit("remesh", remesh,
        {.help = "equal triangles, or more of them where the surface bends", .unit = "", .choices = {"uniform", "adaptive"}});
  visit("keep_components", keep_components,
        {.help = "pieces of the result, largest first; 0 keeps all", .unit = "pieces", .min = 0, .max = 1000000});
  visit("min_component", min_component,
        {.help = "pieces with less than this share of the largest one's area are dropped", .unit = "", .min = 0, .max = 1});
  visit("wrap", wrap, {.help = "allow an alpha wrap when local repair fails", .unit = ""});
  visit("wrap_alpha", wrap_alpha,
        {.help = "alpha of the wrap over the diagonal; 0 chooses it from faces", .unit = "", .min = 0, .max = 0.2});
}

CleanupResult MakeClosedManifold(const Mesh& surface, const CleanupOptions& options, Progress* progress) {
  RequireUsable(surface, "surface");
  const Frame frame = {(surface.points.colwise().minCoeff() + surface.points.colwise().maxCoeff()) / 2, BoundingDiagonal(surface.points)};
  if (!(frame.diagonal > 0) || !std::isfinite(frame.diagonal)) {
    throw InputError("cleanup: the surface has no extent (all vertices coincide, or coordinates overflow); nothing can be closed");
  }
  const Mesh normalized = Normalized(surface, frame);
  CleanupResult result;
  if (KeptAsIs(surface, normalized, options)) {
    result.mesh = surface;
    result.rung = "as-is";
    Measure(surface, frame.diagonal, result);
    return result;
  }
  Ladder ladder(normalized, options, progress, result);
  result.mesh = ladder.Climb();
  Step(progress, 0.9, "measuring");
  MeasureDistances(result.mesh, normalized, ladder.kept(), result);
  result.mesh.points = (result.mesh.points * frame.diagonal).rowwise() + frame.center;
  if (surface.colors.rows() == surface.points.rows()) result.mesh.colors = ColorsFrom(surface, result.mesh.points);
  Measure(result.mesh, frame.diagonal, result);
  return result;
}

}  // namespace keypose::cleanup
