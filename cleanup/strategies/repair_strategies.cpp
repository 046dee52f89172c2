#include "cleanup/strategies/repair_strategies.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <utility>

#include "cleanup/editing/adapt.h"
#include "cleanup/editing/decimate.h"
#include "cleanup/editing/size_field.h"
#include "cleanup/repair/components.h"
#include "cleanup/repair/handle_loops.h"
#include "cleanup/repair/handles.h"
#include "cleanup/repair/holes.h"
#include "cleanup/repair/intersections.h"
#include "cleanup/repair/see_through.h"
#include "cleanup/repair/soup.h"
#include "cleanup/repair/wrap.h"
#include "cleanup/strategies/changed_faces.h"
#include "cleanup/strategies/measure.h"
#include "cleanup/support/support_cut.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "core/values/tuned.h"

namespace keypose::cleanup {
namespace {

constexpr double kWeld = 1e-7;    // of the diagonal
constexpr int kWorkingFaces = 5;  // times the wanted faces: limit of the mesh that is repaired
constexpr double kStartFaces =
    2.5;  // times the wanted faces: limit of the mesh where remeshing starts
constexpr int kIntersectionRounds = 8;
// later ones have smaller triangles where earlier results intersected themselves
constexpr int kRemeshings = 3;
constexpr double kStrategyCountTolerance = 0.01;
constexpr double kLeastAngleDeg = 2;

// Chosen on the collection of bad meshes and the thousand mutilated ones (docs/results/cleanup.md);
// no record of the trials.
struct RepairTuning {
  KEYPOSE_TUNED(double, kTouch, 0.005);  // of the diagonal: pieces this near belong together
  // share of intersecting faces above which local repair is slow and does not succeed
  KEYPOSE_TUNED(double, kTangle, 0.02);
  KEYPOSE_TUNED(int, kTangleFaces, 300);  // faces: up to this number, local repair is always tried
  // share of the surface that may be farther than kLostDistance from a local repair
  KEYPOSE_TUNED(double, kLostShare, 0.01);
  KEYPOSE_TUNED(double, kLostDistance, 0.02);  // of the diagonal
  KEYPOSE_TUNED(double, kGoodAngleDeg, 12);    // degrees: wanted for remeshed surfaces
  // EdgeSizeTuning's kExponent and kGrowth for wraps: the rims of a wrapped sheet shrink unless
  // their triangles are much smaller
  KEYPOSE_TUNED(double, kWrapExponent, 0.5);
  KEYPOSE_TUNED(double, kWrapGrowth, 0.4);
};

PointsX3 FaceCenters(const Mesh& mesh, const std::vector<int>& faces) {
  PointsX3 centers(std::ssize(faces), 3);
  for (std::size_t i = 0; i < faces.size(); ++i)
    centers.row(i) =
        (mesh.points.row(mesh.faces(faces[i], 0)) + mesh.points.row(mesh.faces(faces[i], 1)) +
         mesh.points.row(mesh.faces(faces[i], 2))) /
        3;
  return centers;
}

SizeRules RulesOf(const CleanupOptions& options, bool wrapped) {
  SizeRules rules;
  rules.faces = options.faces;
  rules.follow_curvature = options.remesh == "adaptive";
  if (wrapped) {
    rules.exponent = RepairTuning::kWrapExponent;
    rules.growth = RepairTuning::kWrapGrowth;
  }
  return rules;
}

}  // namespace

bool Acceptable(const Mesh& mesh) {
  return mesh.face_count() > 0 && CheckClosed(mesh).closed() && !SelfIntersects(mesh);
}

int WantedGenus(const Mesh& closed, const CleanupOptions& options,
                const std::vector<SightLine>& lines) {
  if (options.genus == -1) return std::numeric_limits<int>::max();
  return options.genus >= 0 ? options.genus : HandlesSeenThrough(closed, lines);
}

bool RepairStrategies::GoodSize(int faces) const {
  return std::abs(faces - options_.faces) <= kStrategyCountTolerance * options_.faces;
}

bool RepairStrategies::MayStay(int faces) const {
  return GoodSize(faces) || (faces < options_.faces && !MustHitCount());
}

bool RepairStrategies::Apart(const Mesh& mesh) const {
  return options_.keep_components == 1 && FindPieces(mesh).list.size() > 1;
}

bool RepairStrategies::AcceptableInFrame(const Mesh& mesh) const {
  Mesh there = mesh;
  there.points = frame_.Of(mesh.points) / frame_.diagonal;
  return Acceptable(there);
}

// CGAL reports a violated precondition as std::logic_error. Then only this strategy has failed. Its
// counts in the result are discarded.
std::optional<Mesh> RepairStrategies::Try(const char* strategy,
                                          const std::function<std::optional<Mesh>()>& step) {
  const CleanupResult before = result_;
  try {
    std::optional<Mesh> mesh = step();
    if (mesh && AcceptableInFrame(*mesh)) {
      result_.strategy = strategy;
      return mesh;
    }
    if (mesh)
      last_fault_ =
          std::string(strategy) + (CheckClosed(*mesh).closed() ? ": the mesh intersects itself"
                                                               : ": the mesh is not closed");
  } catch (const std::logic_error& error) {
    last_fault_ = std::string(strategy) + ": " + error.what();
  }
  result_ = before;
  return std::nullopt;
}

void RepairStrategies::Weld() {
  SoupResult soup = OrientedManifold(input_, kWeld);
  result_.merged_vertices = soup.merged_vertices;
  // Stitching closes the cuts around a fin, but only after the fin is removed. It also joins
  // pieces. So it runs before and after small pieces are removed.
  kept_ = Stitched(
      WithoutBits(Stitched(soup.mesh), options_.min_component, &result_.components_removed));
  RemoveSupport();
  CutAtGround();
  if (options_.keep_components == 1)
    kept_ = WithTouchingPieces(kept_, RepairTuning::kTouch, &result_.components_removed);
}

// Searches again after each cut, because there can be a second, lower sheet below a cloth. What a
// cut leaves of the sheet's rim is removed as a small or distant piece.
void RepairStrategies::RemoveSupport() {
  if (options_.support != "auto") return;
  for (int sheets = 0; sheets < 3; ++sheets) {
    const std::optional<CutPlane> plane = FindSupport(kept_);
    if (!plane) return;
    kept_ = Cut(*plane);
    ++result_.supports_removed;
  }
}

Mesh RepairStrategies::Cut(const CutPlane& plane) {
  const Mesh above = OrientedManifold(ClippedAbove(kept_, plane), kWeld).mesh;
  return WithoutBits(above, options_.min_component, &result_.components_removed);
}

void RepairStrategies::CutAtGround() {
  if (!ground_ || kept_.face_count() == 0) return;
  const double below = *ground_ - kept_.points.col(2).minCoeff();
  if (below <= 0) return;
  kept_ = Cut({Eigen::Vector3d::UnitZ(), *ground_});
  result_.cut_below_ground_over_diag = below;
}

// Remeshing moves vertices at the edge of a sole by some thousandths of an edge length. Nothing may
// stay below the ground, and soles must be flat.
Mesh RepairStrategies::OnGround(const Mesh& mesh) const {
  if (!ground_) return mesh;
  Mesh flat = mesh;
  for (Eigen::Index v = 0; v < flat.points.rows(); ++v)
    flat.points(v, 2) = std::max(flat.points(v, 2), *ground_);
  return Acceptable(flat) ? flat : mesh;
}

void RepairStrategies::Fill() {
  HolesResult holes = FillHoles(working_, progress_);
  result_.holes_filled = holes.filled;
  result_.largest_hole_over_diag = holes.largest_over_diag;
  filled_ = std::move(holes.mesh);
  OrientOutward(filled_);
  if (CheckClosed(filled_).zero_area_faces > 0)
    filled_ = WithoutThinAngles(filled_, kLeastAngleDeg);
  IntersectingFaces(filled_, &result_.self_intersections_before);
}

// Local repair of a closed mesh; nothing when it fails.
std::optional<Mesh> RepairStrategies::Mended(const Mesh& mesh) {
  if (Acceptable(mesh)) return mesh;
  if (mesh.face_count() == 0 || !CheckClosed(mesh).finite) return std::nullopt;
  if (static_cast<double>(IntersectingFaces(mesh).size()) >
      std::max<double>(RepairTuning::kTangleFaces, RepairTuning::kTangle * mesh.face_count()))
    return std::nullopt;
  Mesh mended = WithoutIntersections(mesh, kIntersectionRounds);
  if (mended.face_count() > 0 && CheckClosed(mended).zero_area_faces > 0)
    mended = WithoutThinAngles(mended, kLeastAngleDeg);
  if (mended.face_count() == 0) return std::nullopt;
  OrientOutward(mended);
  // Removing an intersection can cut through a thin part.
  mended = LargestPieces(mended, options_.keep_components, &result_.components_removed);
  if (Acceptable(mended)) return mended;
  return std::nullopt;
}

Mesh RepairStrategies::WithGenus(const Mesh& mesh) {
  const int genus = Genus(mesh);
  if (genus == 0) return mesh;
  const int wanted = WantedGenus(mesh, options_, lines_);
  result_.genus_before = std::max(result_.genus_before, genus);
  if (genus <= wanted) return mesh;
  ReportProgress(progress_, 0.6, "cutting handles");
  HandlesResult result = WithoutHandles(mesh, wanted, lines_);
  result_.handles_cut += result.cut;
  for (const double length : result.lengths)
    result_.largest_handle_cut_over_diag = std::max(result_.largest_handle_cut_over_diag, length);
  return std::move(result.mesh);
}

// Removes thin faces of the input and of filled holes where this causes no self-intersection.
Mesh RepairStrategies::WithBetterAngles(const Mesh& mesh, double enough_deg) {
  const double least_deg = LeastAngleDeg(mesh);
  if (least_deg >= enough_deg) return mesh;
  for (const double wanted_deg : {RepairTuning::kGoodAngleDeg, 4 * kLeastAngleDeg,
                                  2 * kLeastAngleDeg, 1.1 * kLeastAngleDeg}) {
    if (wanted_deg > 2 * enough_deg || wanted_deg <= least_deg) continue;
    const Mesh better = WithoutThinAngles(mesh, wanted_deg);
    if (LeastAngleDeg(better) > least_deg && MayStay(better.face_count()) && Acceptable(better))
      return better;
  }
  return mesh;
}

std::optional<Mesh> RepairStrategies::AtWantedSize(const Mesh& base) {
  const SizeRules rules = RulesOf(options_, wrapped_);
  Eigen::VectorXd sizes = EdgeSizes(base, rules);
  const Mesh start = base.face_count() > kStartFaces * rules.faces
                         ? Decimated(base, static_cast<int>(kStartFaces * rules.faces))
                         : base;
  std::optional<Mesh> with_slivers;
  const CleanupResult before = result_;
  CleanupResult result_with_slivers;
  for (int attempt = 0; attempt < kRemeshings; ++attempt) {
    ReportProgress(progress_, 0.7 + 0.05 * attempt, "remeshing");
    result_ = before;
    const Mesh mesh = Remeshed(start, base, sizes, rules.faces);
    if (!GoodSize(mesh.face_count())) break;
    if (const std::optional<Mesh> mended = Mended(mesh); mended && GoodSize(mended->face_count())) {
      Mesh better = WithBetterAngles(*mended, RepairTuning::kGoodAngleDeg);
      if (LeastAngleDeg(better) >= kLeastAngleDeg) return better;
      if (!with_slivers) {
        with_slivers = std::move(better);
        result_with_slivers = result_;
      }
    }
    Refine(base, FaceCenters(mesh, IntersectingFaces(mesh)), 3, sizes);
  }
  result_ = with_slivers ? result_with_slivers : before;
  if (with_slivers) return with_slivers;
  // Decimation alone: keeps sharp features better, but triangles are less even.
  Mesh decimated =
      base.face_count() > rules.faces ? Decimated(base, rules.faces) : SplitTo(base, rules.faces);
  const std::optional<Mesh> mended = Mended(decimated);
  if (!mended || mended->face_count() > (1 + kStrategyCountTolerance) * rules.faces)
    return std::nullopt;
  return WithBetterAngles(GoodSize(mended->face_count()) ? *mended : SplitTo(*mended, rules.faces),
                          kLeastAngleDeg);
}

std::optional<Mesh> RepairStrategies::Finish(const Mesh& base) {
  repaired_ = WithGenus(LargestPieces(base, options_.keep_components, &result_.components_removed));
  if (MayStay(repaired_.face_count())) return WithBetterAngles(repaired_, kLeastAngleDeg);
  const std::optional<Mesh> mesh = AtWantedSize(repaired_);
  // After remeshing, a cut may succeed that failed between thin faces.
  if (!mesh || Genus(*mesh) <= WantedGenus(*mesh, options_, lines_)) return mesh;
  const Mesh cut = WithGenus(*mesh);
  return MayStay(cut.face_count()) ? cut : SplitTo(cut, options_.faces);
}

std::optional<Mesh> RepairStrategies::Wrap(double alpha, double offset_share, bool project) {
  ReportProgress(progress_, 0.5, "wrapping");
  const double offset = alpha * offset_share;
  Mesh wrap = LargestPieces(AlphaWrap(filled_, alpha, offset), options_.keep_components,
                            &result_.components_removed);
  if (project) wrap = ProjectedBack(wrap, filled_, 3 * offset);
  if (!Acceptable(wrap)) return std::nullopt;
  return Finish(wrap);
}

// Wraps with larger balls have fewer faces, so one of them finally needs no remeshing. A wrap never
// intersects itself.
std::optional<Mesh> RepairStrategies::CoarseWraps(double alpha) {
  const CleanupResult before = result_;
  for (; alpha < 2; alpha *= 1.5) {
    ReportProgress(progress_, 0.6, "wrapping coarsely");
    result_ = before;
    const Mesh wrap = LargestPieces(AlphaWrap(filled_, alpha, alpha / 2), options_.keep_components,
                                    &result_.components_removed);
    if (!Acceptable(wrap)) continue;
    repaired_ = wrap;
    const Mesh mesh = WithGenus(wrap);
    if (mesh.face_count() > (1 + kStrategyCountTolerance) * options_.faces) continue;
    return WithBetterAngles(MayStay(mesh.face_count()) ? mesh : SplitTo(mesh, options_.faces),
                            kLeastAngleDeg);
  }
  return std::nullopt;
}

// The two walls around a thin sheet are closer together than the edge length, and remeshing makes
// such walls intersect. Then thicker wraps are tried.
std::optional<Mesh> RepairStrategies::WrapStrategies() {
  wrapped_ = true;
  const double area = SurfaceArea(filled_.points, filled_.faces);
  const double automatic = std::clamp(std::sqrt(2 * area / options_.faces), 1.0 / 250, 1.0 / 30);
  const double alpha = options_.wrap_alpha > 0 ? options_.wrap_alpha : automatic;
  const std::pair<const char*, std::function<std::optional<Mesh>()>> strategies[] = {
      {"R4 wrap", [&] { return Wrap(alpha, 1.0 / 30, true); }},
      {"R4 thick wrap", [&] { return Wrap(alpha, 1.0 / 3, false); }},
      {"R4 coarse wrap", [&] { return Wrap(2 * alpha, 1.0 / 2, false); }},
      {"R4 coarse wrap", [&] { return CoarseWraps(2 * alpha); }},
  };
  std::optional<Mesh> with_slivers;
  const CleanupResult before = result_;
  CleanupResult result_with_slivers;
  for (const auto& [name, step] : strategies) {
    result_ = before;
    std::optional<Mesh> mesh = Try(name, step);
    if (!mesh) continue;
    if (LeastAngleDeg(*mesh) >= kLeastAngleDeg) return mesh;
    if (with_slivers) continue;
    with_slivers = std::move(mesh);
    result_with_slivers = result_;
  }
  if (with_slivers) result_ = result_with_slivers;
  return with_slivers;
}

std::optional<Mesh> RepairStrategies::Welded() {
  Mesh turned = working_;
  OrientOutward(turned);
  if (Apart(turned) || !Acceptable(turned)) return std::nullopt;
  return Finish(turned);
}

// If vertices of distant places were merged, removing the intersections can cut off a limb.
std::optional<Mesh> RepairStrategies::MendedWhole() {
  const std::optional<Mesh> mended = Mended(filled_);
  if (!mended) return std::nullopt;
  if (ShareFartherThan(kept_, *mended, RepairTuning::kLostDistance) > RepairTuning::kLostShare) {
    last_fault_ = "R3 intersections: local repair lost a part of the surface";
    return std::nullopt;
  }
  return Finish(*mended);
}

Mesh RepairStrategies::Changed() const { return ChangedFaces(working_, repaired_); }

Mesh RepairStrategies::Run() {
  ReportProgress(progress_, 0.02, "checking");
  Weld();
  ReportProgress(progress_, 0.15, "welded");
  const double limit = static_cast<double>(kWorkingFaces) * options_.faces;
  working_ = kept_.face_count() > limit ? Decimated(kept_, static_cast<int>(limit)) : kept_;
  ReportProgress(progress_, 0.3, "decimated");
  if (auto mesh = Try("R0 weld", [&] { return Welded(); })) return *mesh;
  try {
    Fill();
  } catch (const std::logic_error& error) {  // CGAL does not accept this case; the wrap accepts all
    last_fault_ = std::string("R2 fill: ") + error.what();
    filled_ = working_;
  }
  ReportProgress(progress_, 0.4, "holes filled");
  // Pieces that belong together but are not joined: only the wrap turns them into one surface.
  if (Apart(filled_)) {
    last_fault_ =
        "pieces that touch or intersect can only be joined by the wrap, or kept apart with "
        "--keep_components 0";
  } else {
    if (auto mesh =
            Try("R2 fill", [&] { return Acceptable(filled_) ? Finish(filled_) : std::nullopt; }))
      return *mesh;
    if (auto mesh = Try("R3 intersections", [&] { return MendedWhole(); })) return *mesh;
  }
  if (options_.wrap) {
    if (auto mesh = WrapStrategies()) return *mesh;
  }
  throw QualityError(
      "cleanup: no repair strategy gave a closed surface without self-intersections" +
      (last_fault_.empty() ? std::string() : " (" + last_fault_ + ")") +
      "; look at the surface, or try other values of --faces and --wrap_alpha");
}

}  // namespace keypose::cleanup
